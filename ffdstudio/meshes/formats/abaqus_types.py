"""What the element types of Abaqus and CalculiX are made of."""

from __future__ import annotations

import re

from ffdstudio.meshes.topology import CORNERS

SOLID = {
    4: "tetra",
    5: "pyramid",
    6: "wedge",
    8: "hexahedron",
    10: "tetra10",
    15: "wedge15",
    20: "hexahedron20",
}
PLANE = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}
LINE = {2: "line", 3: "line3"}
_SOLID = re.compile(r"(?:C3D|F3D|DC3D|AC3D)(\d+)")
_PLANE = re.compile(
    r"(?:STRI|SFM3D|M3D|R3D|CPS|CPEG|CPE|CAX|CGAX|DC2D|DCAX|DS|AC2D|SAX|S|RAX)(\d)(?!\d)"
)
_LINE = re.compile(r"(?:T2D|T3D|R2D)(\d)|B[23](\d)")


def kind_of(name: str) -> tuple[str, int] | None:
    """Our type and number of nodes for a type of Abaqus.

    Examples
    --------
    >>> kind_of("C3D8R"), kind_of("S4R"), kind_of("B31"), kind_of("SPRING1")
    (('hexahedron', 8), ('quad', 4), ('line', 2), None)
    """
    upper = name.strip().upper()
    if match := _SOLID.match(upper):
        found = SOLID.get(int(match[1]))
    elif match := _LINE.match(upper):
        nodes = int(match[1]) if match[1] else int(match[2]) + 1
        found = LINE.get(nodes)
    elif match := _PLANE.match(upper):
        found = PLANE.get(int(match[1]))
    else:
        return None
    if found is None:
        return None
    digits = re.search(r"\d+$", found)
    return found, int(digits[0]) if digits else CORNERS[found]
