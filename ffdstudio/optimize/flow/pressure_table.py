"""Target pressures from a file: tables of x and Cp, as solvers and wind tunnels give them.

A line holds ``x, cp`` or ``x, cp, side`` with the side "upper" or "lower", x in chords; a line
of names may come first. Without sides the rows run from the upper trailing edge over the nose
to the lower one, as a contour does. Between two rows Cp is linear in the root of x, since near
the nose it follows the arc of the surface rather than the chord.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array, Mask
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes

SIDES = {"upper": True, "lower": False}
FORE, AFT = 0.05, 0.95  # how far a side has to reach, for its ends are held


@dataclass(frozen=True)
class PressureTable:
    """Pressures by abscissa, for each side.

    Attributes
    ----------
    upper, lower : numpy.ndarray
        (m, 2) x and cp, x growing.
    """

    upper: Array
    lower: Array

    def at(self, x: Array, upper: Mask) -> Array:
        """(n,) pressures at abscissae of the sides that `upper` names.

        Examples
        --------
        >>> table = PressureTable(np.array([[0.0, 1], [1, 0]]), np.array([[0.0, 1], [1, 1]]))
        >>> table.at(np.array([0.25, 0.25]), np.array([True, False]))
        array([0.5, 1. ])
        """
        root = np.sqrt(np.clip(x, 0.0, None))
        both = [
            np.interp(root, np.sqrt(side[:, 0]), side[:, 1]) for side in (self.upper, self.lower)
        ]
        return np.where(upper, *both)


def panels(points: Array) -> tuple[Array, Mask]:
    """Abscissae of the panel middles of a contour, and which are on the upper side."""
    middles = 0.5 * (points[1:, 0] + points[:-1, 0])
    return middles, np.arange(len(middles)) < int(np.argmin(points[:, 0]))


def read_pressures(path: str | os.PathLike[str]) -> PressureTable:
    """Table of a file.

    Raises
    ------
    InputError
        If a line is none of a table, or a side is missing or too short.
    """
    lines = read_bytes(path).decode(errors="replace").splitlines()
    rows = [(k, line.replace(",", " ").split()) for k, line in enumerate(lines, start=1)]
    rows = [(k, words) for k, words in rows if words and not words[0].startswith("#")]
    if rows and not _is_number(rows[0][1][0]):
        rows = rows[1:]
    values = np.array([_row(words, k, path) for k, words in rows]).reshape(-1, 3)
    named = ~np.isnan(values[:, 2])
    if named.any() and not named.all():
        raise InputError(f"{path}: name the side in each line or in none")
    if not named.any() and len(values):
        values[:, 2] = np.arange(len(values)) <= int(np.argmin(values[:, 0]))
    return PressureTable(
        *(_side(values[values[:, 2] == n, :2], name, path) for name, n in SIDES.items())
    )


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _row(words: list[str], number: int, path: str | os.PathLike[str]) -> list[float]:
    side = words[2].lower() if len(words) == 3 else ""
    right = len(words) in (2, 3) and all(map(_is_number, words[:2])) and side in ("", *SIDES)
    found = [float(word) for word in words[:2]] if right else []
    if not right or not np.isfinite(found).all() or not 0 <= found[0] <= 1.001:
        raise InputError(
            f"line {number} of {Path(path)} is no x from 0 to 1, cp and, if given, upper or lower"
        )
    return [*found, float(SIDES[side]) if side else np.nan]


def _side(rows: Array, name: str, path: str | os.PathLike[str]) -> Array:
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    if len(rows) < 2 or rows[0, 0] > FORE or rows[-1, 0] < AFT:
        raise InputError(f"{path}: the {name} side must have pressures from x = {FORE} to {AFT}")
    if (np.diff(rows[:, 0]) == 0).any():
        raise InputError(f"{path}: the {name} side has two pressures at one x")
    return rows
