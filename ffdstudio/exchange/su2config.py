"""FFD boxes as lines of an SU2 configuration: FFD_DEFINITION and what belongs to it.

The configuration knows a box by its eight corners alone, so a net is exact only where its
control points are spread evenly between them.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.exchange import su2
from ffdstudio.exchange.conversion import ConversionRules, adapted
from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.exchange.su2cylinder import cylinder_lattice
from ffdstudio.exchange.su2settings import Settings
from ffdstudio.exchange.su2text import Box
from ffdstudio.exchange.text import chosen, integer, naming, vector
from ffdstudio.files import write_bytes
from ffdstudio.limits import check_control_points

MOVES = "SU2 blends motions in radius, angle and x, here they are blended in x, y, z"
RULES = ConversionRules("an SU2 configuration", dimensions=(2, 3), uniform=True, weights=False)


def recognises(data: bytes) -> bool:
    """Whether it defines a box."""
    return b"FFD_DEFINITION" in data


def write(
    path: Path, content: LatticeFile, adapt: str = "refuse", tag: str = su2.DEFAULT_TAG
) -> Exactness:
    """Write the lines that make SU2 set up this box, to be included in a configuration."""
    fitting, exactness = adapted(content, RULES, adapt)
    lattice = fitting.current
    box = su2.new_box(lattice, tag)
    spanned = su2.lattice_of(Box(tag, 0, box.counts, box.orders, [], [], box.corners, None))
    off = float(np.abs(spanned.control_points - lattice.control_points).max())
    if off > 1e-12 * lattice.diagonal:
        if adapt != "resample":
            raise InputError(
                "an SU2 configuration cannot express this lattice: its control points are not "
                'spread evenly between the corners; put it into the mesh (.su2) or use "resample"'
            )
        reason = f"the control points are spread evenly, they differ by up to {off:.3g}"
        exactness = Exactness(False, reason, "put the box into the mesh (.su2)")
    write_bytes(path, definition(box, content.frozen, content.open_faces).encode())
    return exactness


def definition(box: Box, frozen: int = 0, open_faces: Collection[tuple[int, ...]] = ()) -> str:
    """Return the configuration lines of a box."""
    corners = np.zeros((8, 3))
    corners[: len(box.corners), : box.corners.shape[1]] = box.corners
    numbers = ", ".join(map(repr, corners.ravel().tolist()))
    degrees = [n - 1 for n in box.counts] + [0] * (3 - len(box.counts))
    lines = [
        f"FFD_DEFINITION= ({box.tag}, {numbers})",
        f"FFD_DEGREE= ({', '.join(map(str, degrees))})",
        f"FFD_BLENDING= {'BEZIER' if box.orders is None else 'BSPLINE_UNIFORM'}",
    ]
    if box.orders is not None:
        orders = [*box.orders, 2][:3]
        lines.append(f"FFD_BSPLINE_ORDER= {', '.join(map(str, orders))}")
    return "\n".join([*lines, *_continuity(box.counts, frozen, open_faces), ""])


def read(data: bytes, name: str, block: int | str | None = None) -> LatticeFile:
    """Read one box of a configuration; in 2D the second four corners are all zero."""
    text = re.sub(rb"%[^\n]*", b"", data).replace(b"\\\n", b" ").replace(b"\\\r\n", b" ")
    boxes = [part.replace(b",", b" ").split() for part in _value(text, b"FFD_DEFINITION", name)]
    degrees = [part.replace(b",", b" ").split() for part in _value(text, b"FFD_DEGREE", name)]
    if not boxes or len(degrees) != len(boxes) or any(len(words) != 25 for words in boxes):
        raise InputError(
            f"{name}: FFD_DEFINITION needs a tag and 24 numbers, FFD_DEGREE as many boxes"
        )
    tags = tuple(words[0].decode("utf-8", "replace") for words in boxes)
    index = chosen(tags, block, name, "FFD box")
    corners = vector(boxes[index][1:], name).reshape(8, 3)
    counts = [integer(word, name, "FFD_DEGREE") + 1 for word in degrees[index]]
    settings, orders = Settings(text, name), _orders(text, name)
    around = settings.coordinates() == "CYLINDRICAL"
    if around:
        with naming(f"{name}: FFD box {tags[index]}"):
            rest = cylinder_lattice(corners, counts, orders, settings.axis())
    else:
        rest = _lattice(tags[index], corners, counts, orders, name)
    hold = settings.held(rest.shape)
    current, moves_lost = settings.moved(rest, tags[index], hold)
    lost = (*hold.lost, *moves_lost, *([MOVES] if around else []))
    note = "SU2 has not set this box up: it is spanned by its corners"
    exactness = Exactness(not lost, "; ".join([note, *lost]))
    return LatticeFile(
        rest, current, hold.layers, exactness=exactness, format="su2config", blocks=tags,
        open_faces=hold.open_faces, notes=lost,
    )  # fmt: skip


def _lattice(
    tag: str, corners: Array, counts: list[int], orders: list[int] | None, name: str
) -> Lattice:
    flat = not corners[4:].any()
    dimension = 2 if flat else 3
    if len(counts) != 3 or min(counts[:dimension]) < 2:
        raise InputError(
            f"{name}: FFD_DEGREE needs three numbers, of at least 1 where there is room"
        )
    with naming(f"{name}: FFD box {tag}"):
        check_control_points(counts[:dimension])
    used = corners[:4, :2] if flat else corners
    order = None if orders is None else tuple(orders[:dimension])
    box = Box(tag, 0, tuple(counts[:dimension]), order, [], [], used, None)
    with naming(f"{name}: FFD box {tag}"):
        return su2.lattice_of(box)


def _orders(text: bytes, name: str) -> list[int] | None:
    if not re.search(rb"^\s*FFD_BLENDING\s*=\s*BSPLINE_UNIFORM\b", text, re.MULTILINE):
        return None
    found = re.search(rb"^\s*FFD_BSPLINE_ORDER\s*=([^\n]*)", text, re.MULTILINE)
    words = found[1].strip(b" ()\r").replace(b",", b" ").split() if found else [b"2"] * 3
    orders = [integer(word, name, "FFD_BSPLINE_ORDER") for word in words]
    if len(orders) != 3 or min(orders) < 2:
        raise InputError(f"{name}: FFD_BSPLINE_ORDER needs three orders of at least 2")
    return orders


def _value(text: bytes, key: bytes, name: str) -> list[bytes]:
    """Return the parentheses behind a key."""
    found = re.search(rb"^\s*" + key + rb"\s*=([^\n]*)", text, re.MULTILINE)
    if found is None:
        raise InputError(f"{name}: {key.decode()}= is missing")
    return re.findall(rb"\(([^()]*)\)", found[1])


def _continuity(
    counts: tuple[int, ...], frozen: int, open_faces: Collection[tuple[int, ...]] = ()
) -> list[str]:
    """Frozen layers as SU2's planes of control points that do not move."""
    if not frozen:
        return ["FFD_CONTINUITY= NO_DERIVATIVE"]
    lines = ["FFD_CONTINUITY= USER_INPUT"]
    for axis, (direction, n) in enumerate(zip("IJK", counts, strict=False)):
        lower = range(0 if (axis, 0) in open_faces else min(frozen, n))
        upper = range(n if (axis, 1) in open_faces else max(n - frozen, 0), n)
        planes = sorted({*lower, *upper})
        if planes:
            lines.append(f"FFD_FIX_{direction}= ({', '.join(map(str, planes))})")
    return lines
