"""GoTools ``.g2``: curves, surfaces and volumes in plain text, as Splipy writes and reads them.

A header ``700 1 0 0``, then ``dim rational``, for each direction ``n order`` and the knots,
then the control points, u fastest; rational ones as ``wx wy wz w``.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.exchange.conversion import ConversionRules, adapted
from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.exchange.nets import from_rows, own_axes, to_rows
from ffdstudio.exchange.text import chosen, integer, naming, tokens, vector
from ffdstudio.exchange.ties import untied
from ffdstudio.files import write_bytes
from ffdstudio.limits import check_control_points

RULES = ConversionRules("GoTools .g2", dimensions=(1, 2, 3))
DIRECTIONS = {b"100": 1, b"200": 2, b"700": 3}


def recognises(data: bytes) -> bool:
    """Whether it starts with the header of a curve, surface or volume."""
    words = data[:100].split()
    return len(words) >= 4 and words[0] in DIRECTIONS and words[1:4] == [b"1", b"0", b"0"]


def read(data: bytes, name: str, block: int | str | None = None) -> LatticeFile:
    """Read one object of the file."""
    words = _Words(tokens(data, name), name)
    lattices = []
    while words.left:
        with naming(name):
            lattices.append(_object(words))
    names = tuple(str(k) for k in range(len(lattices)))
    index = chosen(names, block, name, "object")
    lattice = lattices[index]
    told = untied([each.control_points for each in lattices], names, index, "object")
    return LatticeFile(lattice, lattice, format="gotools", blocks=names, notes=told)


def write(path: Path, content: LatticeFile, adapt: str = "refuse") -> Exactness:
    """Write one object."""
    fitting, exactness = adapted(content, RULES, adapt)
    lattice = fitting.current
    rational = bool((lattice.weights != 1).any())
    kind = {1: 100, 2: 200, 3: 700}[lattice.dimension]
    lines = [f"{kind} 1 0 0", f"3 {int(rational)}"]
    for n, p, u in zip(lattice.shape, lattice.degrees, lattice.knots, strict=True):
        lines += [f"{n} {p + 1}", " ".join(map(repr, u.tolist()))]
    net = lattice.homogeneous if rational else lattice.control_points
    lines += [" ".join(map(repr, row)) for row in to_rows(net).tolist()]
    write_bytes(path, ("\n".join(lines) + "\n").encode())
    return exactness


class _Words:
    """Words of the file, taken from the front."""

    def __init__(self, words: list[bytes], name: str) -> None:
        self.words, self.name, self.at = words, name, 0

    @property
    def left(self) -> int:
        return len(self.words) - self.at

    def take(self, count: int) -> list[bytes]:
        if count > self.left:
            raise InputError(f"{self.name}: the file ends too early")
        self.at += count
        return self.words[self.at - count : self.at]

    def count(self, what: str) -> int:
        number = integer(self.take(1)[0], self.name, what)
        if not 0 <= number <= len(self.words):
            raise InputError(f"{self.name}: {what} {number} does not fit the file")
        return number


def _object(words: _Words) -> Lattice:
    kind = words.take(4)[0]
    if kind not in DIRECTIONS:
        raise InputError(
            f"{words.name}: only curves, surfaces and volumes (100, 200, 700) are read"
        )
    space, rational = words.count("the dimension"), words.count("the mark of rational points")
    if space not in (2, 3) or rational > 1:
        raise InputError(f"{words.name}: points must have 2 or 3 coordinates, rational or not")
    shape, degrees, knots = [], [], []
    for _ in range(DIRECTIONS[kind]):
        n, order = words.count("the number of points"), words.count("the order")
        shape.append(n)
        degrees.append(order - 1)
        knots.append(vector(words.take(n + order), words.name))
    if not shape or min(shape) < 2:
        raise InputError("a direction needs at least 2 control points")
    check_control_points(shape)
    count = math.prod(shape)
    rows = vector(words.take(count * (space + rational)), words.name)
    return _lattice(degrees, knots, from_rows(rows.reshape(count, -1), shape), rational)


def _lattice(degrees: list[int], knots: list[Array], net: Array, rational: int) -> Lattice:
    weights = net[..., -1] if rational else np.ones(net.shape[:-1])
    if not (weights > 0).all():
        raise InputError("weights must be positive, finite numbers")
    points = np.zeros((*net.shape[:-1], 3))
    space = net.shape[-1] - rational
    points[..., :space] = net[..., :space] / weights[..., None]
    return Lattice(degrees, knots, points, weights, own_axes(points))
