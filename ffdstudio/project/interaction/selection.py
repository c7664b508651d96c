"""Sets of control points: pure functions on indices (i, j, k).

A selection is a frozenset of index tuples, as many numbers as the net has directions.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

from ffdstudio.project.model import Index

Selection = frozenset[Index]
NOTHING: Selection = frozenset()


def click(selection: Selection, point: Index | None, toggle: bool = False) -> Selection:
    """Return what a click selects: one point, or with `toggle` one more or one less.

    Examples
    --------
    >>> sorted(click(frozenset({(0, 0)}), (1, 0), toggle=True))
    [(0, 0), (1, 0)]
    """
    if point is None:
        return selection if toggle else NOTHING
    return selection ^ {point} if toggle else frozenset({point})


def band(selection: Selection, points: Iterable[Index], add: bool, remove: bool) -> Selection:
    """Return what a rubber band selects: its points, or these added or removed."""
    inside = frozenset(points)
    if add:
        return selection | inside
    return selection - inside if remove else inside


def row(selection: Selection, shape: Index, axis: int) -> Selection:
    """Every row in direction `axis` through a selected point.

    Examples
    --------
    >>> sorted(row(frozenset({(1, 1)}), (3, 2), 0))
    [(0, 1), (1, 1), (2, 1)]
    """
    return _along(selection, shape, (axis,))


def plane(selection: Selection, shape: Index, axis: int) -> Selection:
    """Every plane of constant index in direction `axis` through a selected point."""
    return _along(selection, shape, tuple(k for k in range(len(shape)) if k != axis))


def _along(selection: Selection, shape: Index, free: tuple[int, ...]) -> Selection:
    ranges = (
        [range(n) if k in free else (point[k],) for k, n in enumerate(shape)] for point in selection
    )
    return frozenset(index for each in ranges for index in product(*each))


def everything(shape: Index) -> Selection:
    """All control points of a net."""
    return frozenset(product(*map(range, shape)))


def inverse(selection: Selection, shape: Index) -> Selection:
    """Those that are not selected."""
    return everything(shape) - selection


def grow(selection: Selection, shape: Index) -> Selection:
    """The selected points and their neighbours along the directions of the net.

    Examples
    --------
    >>> sorted(grow(frozenset({(0, 0)}), (3, 3)))
    [(0, 0), (0, 1), (1, 0)]
    """
    return selection | {
        neighbour
        for point in selection
        for axis, count in enumerate(shape)
        for step in (-1, 1)
        if 0 <= (neighbour := _shifted(point, axis, step))[axis] < count
    }


def shrink(selection: Selection, shape: Index) -> Selection:
    """Those whose neighbours are all selected: the inverse of `grow`."""
    return inverse(grow(inverse(selection, shape), shape), shape)


def _shifted(point: Index, axis: int, step: int) -> Index:
    return (*point[:axis], point[axis] + step, *point[axis + 1 :])
