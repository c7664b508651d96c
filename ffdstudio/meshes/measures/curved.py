"""Cells of higher order: Bezier coefficients of their Jacobian, of any order and shape.

1. Triangles, tetrahedra, wedges and pyramids are taken as collapsed squares and cubes, where the
   Jacobian is a polynomial in each parameter; a pyramid's, which is none in its own parameters,
   is one there as well. So all kinds are judged by the same boxes of coefficients (`bezier`).
2. A cell is what its nodes and the space of its shape functions make it: Lagrange cells of full
   order, serendipity ones with fewer. The functions come from the nodes by inverting them.
3. The determinant is known at enough points to give its coefficients exactly, rounding aside.

Nodes are in VTK's order.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import product
from math import comb

import numpy as np

from ffdstudio.aliases import Array

MOST = {"hexahedron": 3}  # order above which rounding would grow too large, 4 for the others
Exponents = tuple[tuple[int, ...], ...]
EDGES = {
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (3, 2), (0, 3)),
    "tetra": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    "pyramid": ((0, 1), (1, 2), (3, 2), (0, 3), (0, 4), (1, 4), (2, 4), (3, 4)),
    "wedge": ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    "hexahedron": (
        *((0, 1), (1, 2), (3, 2), (0, 3), (4, 5), (5, 6)),
        *((7, 6), (4, 7), (0, 4), (1, 5), (2, 6), (3, 7)),
    ),
}
CORNERS = {
    "triangle": ((0, 0), (1, 0), (0, 1)),
    "quad": ((0, 0), (1, 0), (1, 1), (0, 1)),
    "tetra": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "pyramid": ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)),  # collapsed: the apex once
    "wedge": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)),
    "hexahedron": tuple((i, j, k) for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))),
}
MIDDLES = {  # centres of faces and of the cell behind the middles of edges, of second order
    "triangle7": ((1 / 3, 1 / 3),),
    "quad9": ((0.5, 0.5),),
    "hexahedron27": (
        *((0, 0.5, 0.5), (1, 0.5, 0.5), (0.5, 0, 0.5), (0.5, 1, 0.5)),
        *((0.5, 0.5, 0), (0.5, 0.5, 1), (0.5, 0.5, 0.5)),
    ),
    "wedge18": ((0.5, 0, 0.5), (0.5, 0.5, 0.5), (0, 0.5, 0.5)),
    "pyramid14": ((0.5, 0.5, 0),),
}
SECOND = {  # cells of second order: edges, middles, and all exponents
    "triangle6": 2, "triangle7": 2, "quad8": 2, "quad9": 2, "tetra10": 2, "pyramid13": 2,
    "pyramid14": 2, "wedge15": 2, "wedge18": 2, "hexahedron20": 2, "hexahedron27": 2,
}  # fmt: skip


def split(kind: str) -> tuple[str, int]:
    """Linear type and number of nodes that a name tells; 0 for the linear one."""
    match = re.fullmatch(r"([a-z]+)(\d*)", kind)
    return (match[1], int(match[2] or 0)) if match else (kind, 0)


@cache
def order_of(kind: str) -> int:
    """Order of a type of cells of higher order, 0 if it is none that is known here.

    Examples
    --------
    >>> order_of("tetra10"), order_of("hexahedron64"), order_of("quad"), order_of("wedge12")
    (2, 3, 0, 0)
    """
    base, count = split(kind)
    if kind in SECOND:
        return 2
    sizes = {
        "triangle": lambda p: (p + 1) * (p + 2) // 2,
        "quad": lambda p: (p + 1) ** 2,
        "tetra": lambda p: (p + 1) * (p + 2) * (p + 3) // 6,
        "hexahedron": lambda p: (p + 1) ** 3,
    }
    return next(
        (p for p in range(3, MOST.get(base, 4) + 1) if base in sizes and sizes[base](p) == count), 0
    )


# ---- nodes ---------------------------------------------------------------------------------


def places(kind: str) -> Array:
    """(nodes, dimension) of the nodes in the reference cell, whose edges go from 0 to 1."""
    base, _ = split(kind)
    order = order_of(kind)
    corners = np.array(CORNERS[base], dtype=np.float64)
    along = np.arange(1, order)[:, None] / order
    edges = [corners[a] + along * (corners[b] - corners[a]) for a, b in EDGES[base]]
    if base == "pyramid":  # collapsed: above a corner of the base its two parameters stay
        edges[4:] = [np.array([[*corners[k, :2], 0.5]]) for k in range(4)]
    if kind in SECOND:
        rest = [np.array(MIDDLES[kind])] if kind in MIDDLES else []
    else:
        rest = [_inner(base, order)]
    return np.concatenate([corners, *edges, *rest])


def _inner(base: str, order: int) -> Array:
    """Nodes of faces and inside, of an order above the second."""
    grid = np.arange(1, order) / order
    square = np.array([(i, j) for j in grid for i in grid])
    if base == "quad":
        return square
    if base == "triangle":
        return _within(order)
    if base == "hexahedron":
        faces = []
        for axis in range(3):
            for side in (0, 1):
                faces.append(np.insert(square, axis, side, axis=1))
        return np.concatenate(
            [*faces, np.array([(i, j, k) for k in grid for j in grid for i in grid])]
        )
    corners = np.array(CORNERS["tetra"], dtype=np.float64)
    inside = _within(order)
    faces = [
        corners[a] + inside @ np.array([corners[b] - corners[a], corners[c] - corners[a]])
        for a, b, c in ((0, 1, 3), (2, 3, 1), (0, 3, 2), (0, 2, 1))
    ]
    middle = [np.full((1, 3), 0.25)] if order == 4 else []
    return np.concatenate([*faces, *middle])


def _within(order: int) -> Array:
    """Nodes inside a triangle, those of a triangle three orders lower."""
    if order == 3:
        return np.full((1, 2), 1 / 3)
    return (1 + (order - 3) * np.array(CORNERS["triangle"])) / order


# ---- shape functions -----------------------------------------------------------------------


def _exponents(kind: str) -> Exponents:
    """Powers of the parameters in the space of the shape functions."""
    base, _ = split(kind)
    p = order_of(kind)
    every = product(range(p + 1), repeat=len(CORNERS[base][0]))
    tests: dict[str, Callable[[tuple[int, ...]], bool]] = {
        "triangle": lambda e: sum(e) <= p,
        "tetra": lambda e: sum(e) <= p,
        "wedge": lambda e: e[0] + e[1] <= p,
        "quad8": lambda e: e != (2, 2),
        "hexahedron20": lambda e: e.count(2) <= 1,
        "wedge15": lambda e: e[0] + e[1] <= (1 if e[2] == 2 else 2),
        "pyramid": lambda e: e[2] <= p - max(e[:2]),
        "pyramid13": lambda e: e[2] <= p - max(e[:2]) and e[:2] != (2, 2),
    }
    test = tests.get(kind) or tests.get(base)
    found = tuple(e for e in every if test is None or test(e))
    return (*found, (-1, -1)) if kind == "triangle7" else found


def _powers(base: str, exponents: Exponents, x: Array, axis: int = -1) -> Array:
    """(points, functions) powers at points; derivatives by a parameter if `axis` tells one.

    A pyramid has (1 - c) to the higher power of a and b beside them; its derivatives by a and b
    are divided by (1 - c), which is in each of them.
    """
    columns = []
    for e in exponents:
        if e == (-1, -1):
            columns.append(_bubble(x, axis))
        elif base == "pyramid":
            columns.append(_collapsed(x, e, axis))
        else:
            factors = [_power(x[:, k], n, k == axis) for k, n in enumerate(e)]
            columns.append(np.prod(factors, axis=0))
    return np.stack(columns, axis=1)


def _power(x: Array, n: int, derived: bool) -> Array:
    if derived:
        return n * x ** max(n - 1, 0)
    return x**n


def _bubble(x: Array, axis: int) -> Array:
    r, s = x.T
    values = {-1: r * s * (1 - r - s), 0: s * (1 - 2 * r - s), 1: r * (1 - r - 2 * s)}
    return np.asarray(values[axis])


def _collapsed(x: Array, e: tuple[int, ...], axis: int) -> Array:
    a, b, c = x.T
    i, j, n = e
    m = max(i, j)
    if axis in (0, 1):
        plane = _power(a, i, axis == 0) * _power(b, j, axis == 1)
        return np.asarray(plane * (1 - c) ** max(m - 1, 0) * c**n)
    plane = a**i * b**j
    if axis < 0:
        return np.asarray(plane * (1 - c) ** m * c**n)
    slope = (1 - c) ** m * _power(c, n, True) - m * (1 - c) ** max(m - 1, 0) * c**n
    return np.asarray(plane * slope)


# ---- the Jacobian --------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Curve:
    """What it takes to go from the nodes of cells to coefficients of their Jacobian.

    Attributes
    ----------
    tangents : numpy.ndarray
        (dimension, samples, nodes) derivatives at the samples.
    bezier : tuple
        For each parameter the matrix from values at its samples to coefficients.
    """

    tangents: Array
    bezier: tuple[Array, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of coefficients by parameter; three always, the last one 1 in a plane."""
        own = tuple(len(matrix) for matrix in self.bezier)
        return own + (1,) * (3 - len(own))


@cache
def curve(kind: str) -> Curve:
    """Matrices of a type of cells."""
    base, _ = split(kind)
    p = order_of(kind) + (kind == "triangle7")
    degrees = {
        "triangle": (2 * (p - 1), 2 * (p - 1)),
        "quad": (2 * p - 1, 2 * p - 1),
        "tetra": (3 * (p - 1),) * 3,
        "pyramid": (3 * p - 1, 3 * p - 1, 3 * p - 3),
        "wedge": (3 * p - 2, 3 * p - 2, 3 * p - 1),
        "hexahedron": (3 * p - 1,) * 3,
    }[base]
    axes = [(1 - np.cos(np.pi * np.arange(n + 1) / n)) / 2 for n in degrees]
    cube = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    exponents = _exponents(kind)
    inverse = np.linalg.inv(_powers(base, exponents, places(kind)))
    at = _uncollapsed(base, cube)
    tangents = [_powers(base, exponents, at, k) @ inverse for k in range(len(axes))]
    bezier = [np.asarray(np.linalg.inv(_bernstein(x)), dtype=np.float64) for x in axes]
    return Curve(np.stack(tangents), tuple(bezier))


def _uncollapsed(base: str, x: Array) -> Array:
    """Parameters of the cell from those of the cube that it is collapsed from."""
    out = x.copy()
    if base in ("triangle", "wedge"):
        out[:, 0] = x[:, 0] * (1 - x[:, 1])
    elif base == "tetra":
        out[:, 1] = x[:, 1] * (1 - x[:, 2])
        out[:, 0] = x[:, 0] * (1 - x[:, 1]) * (1 - x[:, 2])
    return out


def _bernstein(x: Array) -> Array:
    """(points, degree + 1) Bernstein polynomials, as many as there are points."""
    n = len(x) - 1
    return np.stack([comb(n, k) * x**k * (1 - x) ** (n - k) for k in range(n + 1)], axis=1)


def coefficients(kind: str, x: Array, normal: Array | None = None) -> Array:
    """(a, b, c, k) Bezier coefficients of the Jacobian of cells given as (3, nodes, k).

    In a plane c is 1 and the Jacobian refers to `normal` (3, k), by default z.

    Examples
    --------
    >>> nodes = places("tetra10").T[:, :, None]
    >>> values = coefficients("tetra10", nodes)
    >>> values.shape, bool(np.allclose(values, 1))
    ((4, 4, 4, 1), True)
    """
    made = curve(kind)
    t = np.tensordot(made.tangents, x, axes=(2, 1))  # (dimension, samples, 3, k)
    t = np.moveaxis(t, 2, 1)
    if len(t) == 3:
        values = np.einsum("isk,isk->sk", t[0], np.cross(t[1], t[2], axis=0))
    else:
        area = np.cross(t[0], t[1], axis=0)
        values = area[2] if normal is None else np.einsum("isk,ik->sk", area, normal)
    own = tuple(len(matrix) for matrix in made.bezier)
    values = values.reshape(*own, -1)
    for axis, matrix in enumerate(made.bezier):
        values = np.moveaxis(np.tensordot(matrix, values, axes=(1, axis)), 0, axis)
    return np.asarray(values.reshape(*made.shape, -1))
