"""Airfoil sections: contours from files and the NACA four-digit series.

A contour runs from the trailing edge over the upper side to the leading edge and back along
the lower side (Selig's order). The first and last points are equal where the trailing edge is
closed; no other two neighbours are.
"""

from __future__ import annotations

import os
import re

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.reading import read_mesh

THICKNESS = (0.2969, -0.1260, -0.3516, 0.2843)  # of sqrt(x), x, x^2, x^3 at 20 % thickness, / 5
LAST_CLOSED, LAST_OPEN = -0.1036, -0.1015


def naca4(digits: str, points: int = 101, closed: bool = True) -> Array:
    """Contour of a NACA four-digit section of unit chord.

    Parameters
    ----------
    digits : str
        Such as "0012" or "naca2412": camber and its place in tenths, thickness in percent.
    points : int
        Points of each side, leading and trailing edge included; cosine spacing.
    closed : bool
        Whether the trailing edge is closed (last coefficient -0.1036), else as published.

    Returns
    -------
    numpy.ndarray
        (2 * points - 1, 2) from the trailing edge over the upper side and back.

    Raises
    ------
    InputError
        If it is no four-digit section.

    Notes
    -----
    E. N. Jacobs, K. E. Ward, R. M. Pinkerton, NACA Report 460 (1933).

    Examples
    --------
    >>> naca4("0012", points=3).round(4)
    array([[ 1.    ,  0.    ],
           [ 0.5   ,  0.0529],
           [ 0.    ,  0.    ],
           [ 0.5   , -0.0529],
           [ 1.    ,  0.    ]])
    """
    match = re.fullmatch(r"(?:naca[ -]?)?(\d)(\d)(\d\d)", digits.strip().lower())
    if not match or points < 2 or match[3] == "00" or (match[1] != "0") != (match[2] != "0"):
        raise InputError(f"{digits!r} is no NACA four-digit section that can be made")
    camber, place, thickness = int(match[1]) / 100, int(match[2]) / 10, int(match[3]) / 100
    x = 0.5 * (1 - np.cos(np.linspace(0, np.pi, points)))
    half = _half_thickness(x, thickness, closed)
    line, slope = _camber_line(x, camber, place)
    sine, cosine = np.sin(np.arctan(slope)), np.cos(np.arctan(slope))
    upper = np.stack([x - half * sine, line + half * cosine], axis=1)
    lower = np.stack([x + half * sine, line - half * cosine], axis=1)
    return np.concatenate([upper[::-1], lower[1:]])


def _half_thickness(x: Array, thickness: float, closed: bool) -> Array:
    last = LAST_CLOSED if closed else LAST_OPEN
    powers = np.stack([np.sqrt(x), x, x**2, x**3, x**4])
    half = 5 * thickness * (np.array([*THICKNESS, last]) @ powers)
    if closed:
        half[-1] = 0.0  # the coefficients add up to rounding only
    result: Array = half
    return result


def _camber_line(x: Array, camber: float, place: float) -> tuple[Array, Array]:
    if camber == 0:
        return np.zeros_like(x), np.zeros_like(x)
    front = x < place
    scale = camber / np.where(front, place, 1 - place) ** 2
    line = scale * np.where(front, 2 * place * x - x**2, 1 - 2 * place + 2 * place * x - x**2)
    return line, 2 * scale * (place - x)


def read_airfoil(path: str | os.PathLike[str]) -> Array:
    """Contour of an airfoil file, Selig's or Lednicer's layout.

    Parameters
    ----------
    path : path
        With a number behind it, as in ``flap.dat#2``, one element of several.

    Returns
    -------
    numpy.ndarray
        (n, 2) contour from the trailing edge over the upper side and back.

    Raises
    ------
    InputError
        If the file is no airfoil, or has several elements and none is named; the message names
        file, line and cause.
    """
    file, element = split_element(path)
    return contour(read_mesh(file), element)


def split_element(path: str | os.PathLike[str]) -> tuple[str, int | None]:
    """Name of a file, and the number of the element that is asked for behind it.

    Examples
    --------
    >>> split_element("flap.dat#2"), split_element("rae2822.dat")
    (('flap.dat', 2), ('rae2822.dat', None))
    """
    name = os.fspath(path)
    match = re.fullmatch(r"(.+)#(\d{1,4})", name, re.DOTALL)
    if match is None or os.path.lexists(name):
        return name, None
    return match[1], int(match[2])


def contour(mesh: Mesh, element: int | None = None) -> Array:
    """(n, 2) contour of a mesh that is one chain of lines, as read from an airfoil file.

    Parameters
    ----------
    mesh : Mesh
    element : int, optional
        Which one of several, counted from 1.

    Raises
    ------
    InputError
        If its lines do not follow each other, there are several elements and none is asked
        for, or there is no such element.
    """
    name, lines = mesh.path or "this mesh", mesh.cells.get("line", np.empty((0, 2), dtype=np.int64))
    chains = [cells["line"] for cells in mesh.markers.values() if set(cells) == {"line"}]
    if len(chains) > 1 and element is None:
        raise InputError(
            f"{name} holds {len(chains)} elements, as of a slotted section: choose one by its "
            f"number, such as {name}#1"
        )
    if element is not None:
        chains = chains or [lines]
        if not 1 <= element <= len(chains):
            raise InputError(f"{name} has no element {element}: it has {len(chains)}")
        lines = chains[element - 1]
    if len(lines) < 2 or (lines[1:, 0] != lines[:-1, 1]).any():
        raise InputError(f"{name}: not one contour of lines")
    return mesh.points[np.append(lines[:, 0], lines[-1, 1]), :2].copy()


def contour_mesh(points: Array) -> Mesh:
    """Mesh of lines along a contour (n, 2)."""
    flat = np.asarray(points, dtype=np.float64)
    steps = np.arange(len(flat) - 1)
    xyz = np.column_stack([flat, np.zeros(len(flat))])
    return Mesh(xyz, {"line": np.stack([steps, steps + 1], axis=1)}, dimension=2)
