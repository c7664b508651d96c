"""How large things may be that a file or a caller asks for, each said in one place.

A file of a few bytes can announce a net of a billion control points or lists nested a thousand
deep: whoever reads such a number asks here before anything is made of that size.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from ffdstudio.errors import InputError

MAX_CONTROL_POINTS = 1_000_000  # of a lattice; no file or solver has room for more
MAX_DEGREE = 50  # in one direction; a point then costs 51 cubed products
MAX_WEIGHTS = 1e4  # the largest by the smallest: beyond, points are lost to rounding
MAX_NESTING = 64  # of lists and objects in JSON and TOML
_TEXT_OR_BRACKET = re.compile(r"""\"(?:[^\"\\\n]|\\.)*(?:\"|$)|[\[\]{}]""", re.MULTILINE)


def check_control_points(shape: Sequence[int]) -> None:
    """Refuse a net of more control points than a lattice may have.

    Parameters
    ----------
    shape : sequence of int
        Control points in each direction.

    Raises
    ------
    InputError
        If there are too many.

    Examples
    --------
    >>> check_control_points((8, 6, 4))
    >>> check_control_points((1000, 1000, 60))
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: 1000 x 1000 x 60 control points are more than the 1,000,000 that \
a lattice may have
    """
    if any(count > MAX_CONTROL_POINTS for count in shape) or (
        math.prod(map(int, shape)) > MAX_CONTROL_POINTS
    ):
        raise InputError(
            f"{' x '.join(map(str, shape))} control points are more than the "
            f"{MAX_CONTROL_POINTS:,} that a lattice may have"
        )


def check_degree(degree: int, where: str = "") -> None:
    """Refuse a degree beyond `MAX_DEGREE`; `where` follows the number in the message."""
    if degree > MAX_DEGREE:
        raise InputError(f"degree {degree}{where} is more than {MAX_DEGREE}, the highest there is")


def check_nesting(text: str) -> None:
    """Refuse a text whose brackets, those in quotes aside, are nested too deeply.

    A parser that calls itself for each level would end in a `RecursionError`, or in the
    stack of the interpreter.

    Raises
    ------
    InputError
        If the brackets are nested more than `MAX_NESTING` deep.

    Examples
    --------
    >>> check_nesting("[" * 100)
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: nested too deeply: 64 levels are the most
    """
    if text.count("[") + text.count("{") <= MAX_NESTING:
        return
    depth = 0
    for match in _TEXT_OR_BRACKET.finditer(text):
        depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(match[0], 0)
        if depth > MAX_NESTING:
            raise InputError(f"nested too deeply: {MAX_NESTING} levels are the most")
