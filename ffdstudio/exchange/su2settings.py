"""What an SU2 configuration says about a box besides its corners: what is held, what is moved.

1. ``FFD_FIX_I/J/K`` with ``FFD_CONTINUITY= USER_INPUT`` are planes of control points that stay:
   frozen layers where they are the outermost ones, else named as lost. The other continuities
   hold planes where the box cuts a surface, which the configuration alone does not tell.
2. ``DV_KIND= FFD_CONTROL_POINT`` with ``DV_PARAM`` and ``DV_VALUE`` move control points; -1 as an
   index means all of that direction. Points in held planes stay, as in SU2.
3. Boxes in spherical and polar coordinates are refused; `su2cylinder` reads cylindrical ones.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import product

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.exchange.su2cylinder import in_space
from ffdstudio.exchange.text import integer, real, shown

KINDS = {b"FFD_CONTROL_POINT": 3, b"FFD_CONTROL_POINT_2D": 2}  # indices, and components


@dataclass(frozen=True)
class Hold:
    """Control points that stay.

    Attributes
    ----------
    planes : tuple of frozenset of int
        For each direction.
    layers : int
        Frozen layers that say the same, on all faces but the open ones.
    open_faces : tuple of tuple of int
    lost : tuple of str
        What layers cannot say.
    """

    planes: tuple[frozenset[int], ...]
    layers: int = 0
    open_faces: tuple[tuple[int, int], ...] = ()
    lost: tuple[str, ...] = ()


class Settings:
    """Keys of a configuration whose comments are gone already."""

    def __init__(self, text: bytes, name: str) -> None:
        self.text, self.name = text, name

    def value(self, key: bytes) -> bytes:
        """What stands behind a key, or nothing."""
        found = re.search(rb"^\s*" + key + rb"\s*=([^\n]*)", self.text, re.MULTILINE)
        return found[1].strip() if found else b""

    def coordinates(self) -> str:
        """The coordinates that SU2 spans boxes in; `InputError` if they are not read."""
        system = self.value(b"FFD_COORD_SYSTEM").upper() or b"CARTESIAN"
        if system not in (b"CARTESIAN", b"CYLINDRICAL"):
            raise InputError(
                f"{self.name}: FFD_COORD_SYSTEM= {shown(system)} is not read: SU2 spans such a box "
                "in angles; only CARTESIAN and CYLINDRICAL ones are"
            )
        return system.decode()

    def axis(self) -> Array:
        """(3,) point that the axis of cylindrical coordinates goes through."""
        words = self.value(b"FFD_AXIS").strip(b"() ").replace(b",", b" ").split() or [b"0"] * 3
        if len(words) != 3:
            raise InputError(f"{self.name}: FFD_AXIS needs three numbers")
        return np.array([real(word, self.name) for word in words])

    def held(self, shape: tuple[int, ...]) -> Hold:
        """What is held of a box with so many control points in each direction."""
        continuity = self.value(b"FFD_CONTINUITY").upper()
        planes = tuple(
            self._planes(f"FFD_FIX_{d}".encode(), n) for d, n in zip("IJK", shape, strict=False)
        )
        if continuity in (b"1ST_DERIVATIVE", b"2ND_DERIVATIVE"):
            text = continuity.decode()
            return Hold(
                tuple(frozenset[int]() for _ in shape),
                lost=(
                    f"FFD_CONTINUITY= {text} is lost: SU2 holds control points where the box cuts "
                    "a surface; freeze outer layers instead",
                ),
            )
        if continuity not in (b"", b"NO_DERIVATIVE", b"USER_INPUT"):
            raise InputError(f"{self.name}: FFD_CONTINUITY= {shown(continuity)} is not known")
        if continuity != b"USER_INPUT":  # SU2 looks at FFD_FIX_ for nothing else
            return Hold(tuple(frozenset[int]() for _ in shape))
        return layers_of(planes, shape)

    def _planes(self, key: bytes, count: int) -> frozenset[int]:
        words = self.value(key).strip(b"() ").replace(b",", b" ").split()
        planes = [integer(word, self.name, key.decode()) for word in words]
        if not all(0 <= plane < count for plane in planes):
            raise InputError(
                f"{self.name}: {key.decode()}= names a plane that is not in 0 to {count - 1}"
            )
        return frozenset(planes)

    def moved(self, rest: Lattice, tag: str, hold: Hold) -> tuple[Lattice, tuple[str, ...]]:
        """The lattice as design variables deform it, and what of them is lost."""
        kinds = self.value(b"DV_KIND").upper().replace(b",", b" ").split()
        words = self.value(b"DV_VALUE").replace(b",", b" ").split()
        values = [real(word, self.name) for word in words]
        if not any(values):
            return rest, ()
        params = [
            part.replace(b",", b" ").split()
            for part in re.findall(rb"\(([^()]*)\)", self.value(b"DV_PARAM"))
        ]
        if not len(kinds) == len(params) == len(values):
            return rest, (
                f"DV_VALUE is lost: {len(kinds)} DV_KIND, {len(params)} DV_PARAM and {len(values)} "
                "values do not belong together",
            )
        steps, lost = np.zeros_like(rest.control_points), []
        for kind, words, value in zip(kinds, params, values, strict=True):
            if value == 0 or (words and words[0].decode("utf-8", "replace") != tag):
                continue
            if kind not in KINDS:
                lost.append(f"DV_KIND= {kind[:30].decode('ascii', 'replace')} is lost")
                continue
            self._move(steps, rest.shape, KINDS[kind], words[1:], value, hold)
        if rest.frame is not None:
            steps = in_space(rest, steps)
        return rest.moved(rest.control_points + steps), tuple(dict.fromkeys(lost))

    def _move(
        self, steps: Array, shape: tuple[int, ...], axes: int, words: list[bytes], value: float,
        hold: Hold,
    ) -> None:  # fmt: skip
        if len(words) != 2 * axes:
            raise InputError(
                f"{self.name}: DV_PARAM needs a tag, {axes} indices and {axes} components"
            )
        index = [int(real(word, self.name)) for word in words[:axes]][: len(shape)]
        vector = np.zeros(3)
        vector[:axes] = [real(word, self.name) for word in words[axes:]]
        if not all(-1 <= i < n for i, n in zip(index, shape, strict=False)) or len(index) < len(
            shape
        ):
            raise InputError(
                f"{self.name}: DV_PARAM names a control point {index} that is not there"
            )
        lines = [range(n) if i == -1 else (i,) for i, n in zip(index, shape, strict=False)]
        for point in product(*lines):
            if not any(i in planes for i, planes in zip(point, hold.planes, strict=False)):
                steps[point] += value * vector


def layers_of(planes: tuple[frozenset[int], ...], shape: tuple[int, ...]) -> Hold:
    """Planes as frozen layers, as far as those can say it.

    Examples
    --------
    >>> hold = layers_of((frozenset({0, 7}), frozenset({0})), (8, 4))
    >>> hold.layers, hold.open_faces, hold.lost
    (1, ((1, 1),), ())
    """
    depths, lost = {}, []
    for axis, (held, n) in enumerate(zip(planes, shape, strict=True)):
        lower = next((k for k in range(n) if k not in held), n)
        upper = next((k for k in range(n) if n - 1 - k not in held), n)
        depths[axis, 0], depths[axis, 1] = lower, upper
        if len(held) > lower + upper:
            lost.append(f"FFD_FIX_{'IJK'[axis]} holds planes inside the box, which is lost")
    layers = min((depth for depth in depths.values() if depth), default=0)
    if any(depth > layers for depth in depths.values()):
        lost.append(f"FFD_FIX holds more planes on some faces; {layers} on each are taken over")
    ends = [sum(layers for side in (0, 1) if depths[axis, side]) for axis in range(len(shape))]
    if not all(count < n for count, n in zip(ends, shape, strict=True)):
        return Hold(planes, lost=(*lost, "FFD_FIX holds every control point, which is lost"))
    faces = tuple(face for face, depth in depths.items() if not depth and layers)
    return Hold(planes, layers, faces, tuple(lost))
