"""Whether a lattice folds: the sign of its Jacobian determinant over whole knot spans.

1. Without weights the map is a polynomial in each knot span, and so is its Jacobian
   determinant, of degree d p - 1 for degree p and d directions. It lies between its least and
   largest Bezier coefficient: all positive is a proof. A coefficient at a corner is a value: not
   positive is a fold. What stays open is halved.
2. With weights the determinant is rational; it is sampled, and the answer says so.
3. One sign means that the map is locally invertible and no more: it may still overlap itself
   from afar, and cells of a mesh need their own test.
4. A lattice of one or two directions moves points along its axes by the map seen in their
   span; what it adds across is a shear and has no say.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.engine.basis import basis
from ffdstudio.engine.knots import Array
from ffdstudio.engine.lattice import Lattice

DEPTH = 5  # halvings in each direction before a span is called undecided
SAMPLES = 4  # per degree in each direction of a weighted span


@dataclass(frozen=True, eq=False)
class Folds:
    """What is known of the sign of the determinant.

    Attributes
    ----------
    method : str
        How it was found: exact by Bezier coefficients, or sampled and how densely.
    folded : numpy.ndarray
        (spans of each direction) mask of the knot spans with a determinant of the wrong sign.
    undecided : numpy.ndarray
        Mask of the spans where neither a proof nor a fold was found.
    """

    method: str
    folded: np.ndarray
    undecided: np.ndarray

    @property
    def locally_invertible(self) -> bool:
        """Whether no fold was found and nothing is open."""
        return not (self.folded.any() or self.undecided.any())

    def __str__(self) -> str:
        if self.locally_invertible:
            return f"the lattice is locally invertible ({self.method})"
        if self.folded.any():
            return f"the lattice folds in {int(self.folded.sum())} knot spans ({self.method})"
        return f"undecided in {int(self.undecided.sum())} knot spans ({self.method})"


def folds(lattice: Lattice, rest: Lattice | None = None) -> Folds:
    """Check whether a lattice is locally invertible.

    Parameters
    ----------
    lattice : Lattice
    rest : Lattice, optional
        The lattice at rest, whose orientation counts as right; by default the orientation that
        prevails in `lattice`.

    Examples
    --------
    >>> box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 3, 2))
    >>> print(folds(box))
    the lattice is locally invertible (exact, by Bezier coefficients)
    >>> points = box.control_points.copy()
    >>> points[0, :, :, 0] = 2.0
    >>> print(folds(box.moved(points)))
    the lattice folds in 1 knot spans (exact, by Bezier coefficients)
    """
    spans = [_spans(knots) for knots in lattice.knots]
    exact = bool((lattice.weights == 1).all())
    nodes = [_nodes(p, lattice.dimension, exact) for p in lattice.degrees]
    values = _determinants(lattice, spans, nodes)
    reference = (
        values if rest is None else _determinants(rest, [_spans(k) for k in rest.knots], nodes)
    )
    values = values * (1.0 if reference.sum() >= 0 else -1.0)
    shape = tuple(len(s) for s in spans)
    if exact:
        bad, open_ones = _by_coefficients(values, nodes)
        method = "exact, by Bezier coefficients"
    else:
        bad = np.asarray((values <= 0).any(axis=tuple(range(1, values.ndim))))
        open_ones = np.zeros_like(bad)
        dense = "x".join(str(len(n)) for n in nodes)
        method = f"sampled at {dense} points in each knot span, for it has weights"
    return Folds(method, bad.reshape(shape), open_ones.reshape(shape))


def _spans(knots: Array) -> Array:
    """(k, 2) ends of the knot spans that have a length."""
    distinct = np.unique(knots)
    return np.column_stack([distinct[:-1], distinct[1:]])


def _nodes(degree: int, dimension: int, exact: bool) -> Array:
    """Parameters inside (0, 1): as many as the determinant has coefficients, or a dense sample.

    None lies on a knot, where the derivative may jump.
    """
    count = dimension * degree if exact else SAMPLES * degree
    return (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2


def _determinants(lattice: Lattice, spans: list[Array], nodes: list[Array]) -> Array:
    """(spans, nodes of each direction) Jacobian determinants in the span of the axes."""
    places = [(s[:, :1] + np.diff(s) * n).ravel() for s, n in zip(spans, nodes, strict=True)]
    d = lattice.dimension
    net = lattice.homogeneous
    whole = _on_grid(lattice, net, places, -1)
    columns = []
    for k in range(d):
        change = _on_grid(lattice, net, places, k)
        point = whole[..., :3] / whole[..., 3:]
        columns.append(
            (change[..., :3] - point * change[..., 3:]) / whole[..., 3:] @ lattice.axes.T
        )
    values = np.linalg.det(np.stack(columns, axis=-1))
    split = [size for s, n in zip(spans, nodes, strict=True) for size in (len(s), len(n))]
    order = [*range(0, 2 * d, 2), *range(1, 2 * d, 2)]
    return values.reshape(split).transpose(order).reshape(-1, *map(len, nodes))


def _on_grid(lattice: Lattice, net: Array, places: list[Array], axis: int) -> Array:
    """Homogeneous points on a grid of parameters, or their derivative along one direction."""
    for k, u in enumerate(places):
        first, values = basis(lattice.knots[k], lattice.degrees[k], u, int(k == axis))
        matrix = np.zeros((len(u), lattice.shape[k]))
        rows = np.arange(len(u))[:, None]
        matrix[rows, first[:, None] + np.arange(values.shape[1])] = values
        net = _apply(matrix, net, k)
    return net


def _by_coefficients(values: Array, nodes: list[Array]) -> tuple[np.ndarray, np.ndarray]:
    """Which spans are folded and which stay undecided, from the values at the nodes."""
    boxes = values
    noise = np.finfo(np.float64).eps  # of the largest coefficient: below it a sign is no sign
    for axis, place in enumerate(nodes, start=1):
        matrix = np.linalg.inv(_bernstein(len(place) - 1, place))
        noise = max(noise, np.finfo(np.float64).eps * np.abs(matrix).sum(axis=1).max())
        boxes = _apply(matrix, boxes, axis)
    axes = tuple(range(1, boxes.ndim))
    tiny = noise * np.abs(boxes).max(axis=axes)
    span, bad = np.arange(len(boxes)), np.zeros(len(boxes), dtype=bool)
    corners = (slice(None), *(slice(None, None, max(n - 1, 1)) for n in boxes.shape[1:]))
    for _ in range(DEPTH + 1):
        bad[span[(boxes[corners] <= 0).any(axis=axes)]] = True
        open_ones = (boxes.min(axis=axes) <= tiny[span]) & ~bad[span]
        boxes, span = boxes[open_ones], span[open_ones]
        if not len(span):
            break
        for axis in axes:
            boxes = _halved(boxes, axis)
            span = np.tile(span, 2)
    undecided = np.zeros_like(bad)
    undecided[span] = True
    return bad, undecided & ~bad


def _bernstein(degree: int, places: Array) -> Array:
    """(places, degree + 1) Bernstein polynomials."""
    i = np.arange(degree + 1)
    scale = np.array([comb(degree, k) for k in i], dtype=np.float64)
    t = places[:, None]
    return np.asarray(scale * t**i * (1 - t) ** (degree - i), dtype=np.float64)


def _apply(matrix: NDArray[Any], boxes: Array, axis: int) -> Array:
    return np.moveaxis(np.tensordot(matrix, boxes, axes=(1, axis)), 0, axis)


def _halved(boxes: Array, axis: int) -> Array:
    """First halves of all boxes along an axis, then the second ones (de Casteljau)."""
    degree = boxes.shape[axis] - 1
    count = range(degree + 1)
    half = np.array([[comb(i, j) / 2**i for j in count] for i in count], dtype=np.float64)
    parts = [_apply(matrix, boxes, axis) for matrix in (half, half[::-1, ::-1])]
    return np.concatenate(parts)
