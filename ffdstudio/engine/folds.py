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
5. Spans are looked at slab by slab, so that a large lattice does not fill the memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine.lattice import Lattice

DEPTH = 5  # halvings in each direction before a span is called undecided
SAMPLES = 4  # per degree in each direction of a weighted span
AT_ONCE = 200_000  # determinants


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
    ends : tuple of numpy.ndarray
        (spans, 2) parameters between which the spans of each direction lie.
    """

    method: str
    folded: np.ndarray
    undecided: np.ndarray
    ends: tuple[Array, ...] = ()

    @property
    def locally_invertible(self) -> bool:
        """Whether no fold was found and nothing is open."""
        return not (self.folded.any() or self.undecided.any())

    @property
    def answer(self) -> bool | None:
        """True, false, or None where it is not decided."""
        return None if self.undecided.any() and not self.folded.any() else self.locally_invertible

    @property
    def where(self) -> list[list[list[float]]]:
        """Folded spans, or else undecided ones: least and largest parameter by direction."""
        chosen = np.argwhere(self.folded if self.folded.any() else self.undecided)
        return [
            [ends[k].tolist() for ends, k in zip(self.ends, span, strict=True)] for span in chosen
        ]

    def __str__(self) -> str:
        if self.locally_invertible:
            return f"the lattice is locally invertible ({self.method})"
        if self.folded.any():
            return f"the lattice folds in {_spans_of(self.folded)} ({self.method})"
        return f"it is undecided in {_spans_of(self.undecided)} whether it folds ({self.method})"


def _spans_of(mask: np.ndarray) -> str:
    count = int(mask.sum())
    return f"{count} knot span{'' if count == 1 else 's'}"


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
    the lattice folds in 1 knot span (exact, by Bezier coefficients)
    """
    lattice, rest = lattice.clamped(), None if rest is None else rest.clamped()
    spans = [knot_spans(knots) for knots in lattice.knots]
    exact = bool((lattice.weights == 1).all()) and lattice.frame is None
    nodes = [_nodes(p, lattice.dimension, exact) for p in lattice.degrees]
    sign = _orientation(lattice if rest is None else rest)
    answers = []
    for slab in _slabs(spans, nodes):
        values = sign * determinants(lattice, slab, nodes)
        answers.append(_by_coefficients(values, nodes) if exact else _by_samples(values))
    shape = tuple(len(s) for s in spans)
    bad, open_ones = (np.concatenate(part).reshape(shape) for part in zip(*answers, strict=True))
    method = "exact, by Bezier coefficients"
    if not exact:
        dense = "x".join(str(len(n)) for n in nodes)
        why = "has weights" if lattice.frame is None else "follows a curved frame"
        method = f"sampled at {dense} points in each knot span, for it {why}"
    return Folds(method, bad, open_ones, tuple(spans))


def _slabs(spans: list[Array], nodes: list[Array]) -> list[list[Array]]:
    """Spans in pieces along the first direction, in order."""
    sizes = [len(s) * len(n) for s, n in zip(spans, nodes, strict=True)]
    step = max(1, AT_ONCE // (len(nodes[0]) * int(np.prod(sizes[1:]))))
    return [[spans[0][k : k + step], *spans[1:]] for k in range(0, len(spans[0]), step)]


def _orientation(lattice: Lattice) -> float:
    """Sign of the determinant that prevails in the middles of the knot spans."""
    spans = [knot_spans(knots) for knots in lattice.knots]
    middles = [np.array([0.5])] * lattice.dimension
    return 1.0 if determinants(lattice, spans, middles).sum() >= 0 else -1.0


def _by_samples(values: Array) -> tuple[np.ndarray, np.ndarray]:
    """Which spans are folded; none stays undecided."""
    bad = np.asarray((values <= 0).any(axis=tuple(range(1, values.ndim))))
    return bad, np.zeros_like(bad)


def knot_spans(knots: Array) -> Array:
    """(k, 2) ends of the knot spans that have a length."""
    distinct = np.unique(knots)
    return np.column_stack([distinct[:-1], distinct[1:]])


def _nodes(degree: int, dimension: int, exact: bool) -> Array:
    """Parameters inside (0, 1): as many as the determinant has coefficients, or a dense sample.

    None lies on a knot, where the derivative may jump.
    """
    count = dimension * degree if exact else SAMPLES * degree
    return (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2


def determinants(lattice: Lattice, spans: list[Array], nodes: list[Array]) -> Array:
    """(spans, nodes of each direction) Jacobian determinants in the span of the axes."""
    places = [(s[:, :1] + np.diff(s) * n).ravel() for s, n in zip(spans, nodes, strict=True)]
    d = lattice.dimension
    slopes = _slopes(lattice, places)
    if lattice.frame is not None and lattice.reference is not None:
        grid = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1)
        for k, rest in enumerate(_slopes(lattice.reference, places)):
            order = [int(i == k) for i in range(d)]
            frame = lattice.frame.world(grid.reshape(-1, d), order).reshape(rest.shape)
            slopes[k] = frame + (slopes[k] - rest)
    values = _det([slope @ lattice.axes.T for slope in slopes])
    split = [size for s, n in zip(spans, nodes, strict=True) for size in (len(s), len(n))]
    order = [*range(0, 2 * d, 2), *range(1, 2 * d, 2)]
    return values.reshape(split).transpose(order).reshape(-1, *map(len, nodes))


def _slopes(lattice: Lattice, places: list[Array]) -> list[Array]:
    """Derivatives of the spline by each parameter on a grid, (..., 3) each."""
    net = lattice.homogeneous
    whole = _on_grid(lattice, net, places, -1)
    point, weight = whole[..., :3] / whole[..., 3:], whole[..., 3:]
    changes = [_on_grid(lattice, net, places, k) for k in range(lattice.dimension)]
    return [(change[..., :3] - point * change[..., 3:]) / weight for change in changes]


def _det(columns: list[Array]) -> Array:
    """Determinant of the matrices with these columns (..., d)."""
    if len(columns) == 1:
        return columns[0][..., 0]
    a, b = columns[:2]
    if len(columns) == 2:
        return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
    return np.asarray((np.cross(a, b) * columns[2]).sum(axis=-1))


def _on_grid(lattice: Lattice, net: Array, places: list[Array], axis: int) -> Array:
    """Homogeneous points on a grid of parameters, or their derivative along one direction."""
    for k, u in enumerate(places):
        net = _apply(lattice.directions[k].matrix(u, int(k == axis)), net, k)
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
