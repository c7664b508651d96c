"""Arguments with a grammar of their own: ``I,J,K=DX,DY,DZ``, axes, counts."""

from __future__ import annotations

import argparse
import math

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError


def whole(text: str) -> int:
    """Whole number of at least 0, for `argparse`."""
    if not text.isascii() or not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{shortened(text)!r} is no whole number of at least 0")
    return int(text)


def named(text: str) -> str:
    """Name of a file or folder, for `argparse`: an empty one is a variable that was not set."""
    if not text.strip():
        raise argparse.ArgumentTypeError("a name is needed, this one is empty")
    return text


def fraction(text: str) -> float:
    """Finite number of at least 0, for `argparse`."""
    value = _number(text)
    if value is None or value < 0:
        raise argparse.ArgumentTypeError(f"{shortened(text)!r} is no finite number of at least 0")
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
    index = [_index(word.strip()) for word in left.split(",")]
    values = [_number(word) for word in right.split(",")]
    said = f"{option} {shortened(text)}"
    if not equals or None in index or None in values:
        raise InputError(f"{said}: must read {_form(option, lattice.dimension)}")
    if len(index) != lattice.dimension:
        raise InputError(
            f"{said}: this lattice has {lattice.dimension} directions, "
            f"{len(index)} indices were given"
        )
    for name, i, n in zip("IJK", index, lattice.shape, strict=False):
        if i is None or i >= n:
            raise InputError(f"{said}: {name} runs from 0 to {n - 1}")
    return tuple(i for i in index if i is not None), np.array(values, dtype=np.float64)


def shortened(text: str) -> str:
    """Return an argument as a message shows it."""
    return text if len(text) <= 60 else f"{text[:57]}..."


def _form(option: str, dimension: int) -> str:
    values = "W" if option == "--weight" else "DX,DY[,DZ]" if dimension == 2 else "DX,DY,DZ"
    return f"{','.join('IJK'[:dimension])}={values}"


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


def _index(text: str) -> int | None:
    try:
        return whole(text)
    except argparse.ArgumentTypeError:
        return None


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None
