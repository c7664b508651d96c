"""Arguments with a grammar of their own: ``I,J,K=DX,DY,DZ``, axes, counts."""

from __future__ import annotations

import argparse
import math

import numpy as np

from ffdstudio.engine import Lattice
from ffdstudio.engine.knots import Array
from ffdstudio.errors import InputError


def whole(text: str) -> int:
    """Whole number of at least 0, for `argparse`."""
    if not text.isascii() or not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number of at least 0")
    return int(text)


def fraction(text: str) -> float:
    """Finite number of at least 0, for `argparse`."""
    value = _number(text)
    if value is None or value < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is no finite number of at least 0")
    return value


def assignment(text: str, option: str, lattice: Lattice) -> tuple[tuple[int, ...], Array]:
    """Index of a control point and the numbers assigned to it.

    Raises
    ------
    InputError
        If the text has another form or there is no such control point.

    Examples
    --------
    >>> box = Lattice.box([0, 0], [1, 1], shape=(3, 3))
    >>> assignment("1,2=0,0.5,0", "--move", box)
    ((1, 2), array([0. , 0.5, 0. ]))
    """
    left, equals, right = text.partition("=")
    words = left.split(",")
    values = [_number(word) for word in right.split(",")]
    if not equals or not all(word.strip().isdecimal() for word in words) or None in values:
        raise InputError(f"{option} {text}: must read {_FORMS[option]}")
    index = tuple(int(word) for word in words)
    if len(index) != lattice.dimension:
        raise InputError(
            f"{option} {text}: this lattice has {lattice.dimension} directions, "
            f"{len(index)} indices were given"
        )
    for name, i, n in zip("IJK", index, lattice.shape, strict=False):
        if i >= n:
            raise InputError(f"{option} {text}: {name} runs from 0 to {n - 1}")
    return index, np.array(values, dtype=np.float64)


_FORMS = {"--move": "I,J,K=DX,DY,DZ", "--weight": "I,J,K=W"}


def axes(text: str) -> list[list[float]]:
    """Coordinate axes by letter, for `argparse`.

    Examples
    --------
    >>> axes("xz")
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    """
    if not text or not set(text) <= set("xyz") or len(set(text)) < len(text):
        raise argparse.ArgumentTypeError(f"{text!r} must be different letters out of x, y, z")
    return [[float(letter == axis) for axis in "xyz"] for letter in text]


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None
