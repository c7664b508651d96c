"""What the element types of Abaqus and CalculiX are made of.

Source: Abaqus element index and CalculiX manual: the letters in front of the digits name the
family; the digits, where no letter for a variant follows, count the nodes.
"""

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
PLANE = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
LINE = {2: "line", 3: "line3"}
# continuum, fluid, heat, acoustic, electric, piezoelectric, Eulerian, infinite and thermal-
# electrochemical solids, then continuum shells, cohesive cells and gaskets
_SOLID = re.compile(
    r"(?:C3D|F3D|FC3D|DC3D|DCC3D|AC3D|EC3D|EMC3D|QEC3D|Q3D|CIN3D|ACIN3D|CSS|SC|COH3D|COD3D|GK3D)(\d+)"
)
_PLANE = re.compile(
    r"(?:SFMGAX|SFM3D|MCL|M3D|R3D|CPS|CPEG|CPE|CAX|CGAX|CINPE|CINPS|CINAX|DC2D|DCC2D|DCCAX|DCAX|"
    r"EMC2D|DS|AC2D|ACAX|ACIN2D|F2D|FC2D|WARP2D|COH2D|COHAX|COD2D|CODAX|GKPS|GKPE|GKAX|GK2D|US|S)"
    r"(\d)(?!\d)"
)
_SHELL = re.compile(r"STRI(?:(3)|(6)5)")
_LINE = re.compile(r"(?:T2D|T3D|R2D|DC1D|AC1D|F2D|RB2D|RB3D)(\d)|B[23](\d)")
# what has neither area nor volume: beams, pipes, links, springs, masses, axisymmetric shells
_SLENDER = re.compile(
    r"B[23]|PIPE|ELBOW|FRAME|T[23]D|RB[23]D|R2D|RAX|SAX|MAX|SFMAX|DSAX|DC1D|AC1D|DCC1D|SPRING|"
    r"DASHPOT|MASS|ROTARYI|CONN|GAP|ITS|ITT|JOINT|DCOUP|DISTRIB|HEATCAP|DRAG|PSI|POINT|ACIN|CYL"
    r"|GK3D2|GK2D2|D$|SEATBELT|ISL|IRS|PC3D|DISCRETE"
)


def kind_of(name: str) -> tuple[str, int] | None:
    """Our type and number of nodes for a type of Abaqus.

    Examples
    --------
    >>> kind_of("C3D8R"), kind_of("S4R"), kind_of("B31"), kind_of("SPRING1")
    (('hexahedron', 8), ('quad', 4), ('line', 2), None)
    >>> kind_of("SC8R"), kind_of("COH3D6"), kind_of("STRI65"), kind_of("GK3D12M")
    (('hexahedron', 8), ('wedge', 6), ('triangle6', 6), None)
    """
    upper = name.strip().upper()
    if match := _SOLID.match(upper):
        found = SOLID.get(int(match[1]))
    elif match := _SHELL.match(upper):
        found = PLANE.get(int(match[1] or match[2]))
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


def is_slender(name: str) -> bool:
    """Whether elements of a type have neither area nor volume that could be turned inside out.

    Examples
    --------
    >>> is_slender("CONN3D2"), is_slender("SAX1"), is_slender("C3D27")
    (True, True, False)
    """
    return _SLENDER.match(name.strip().upper()) is not None
