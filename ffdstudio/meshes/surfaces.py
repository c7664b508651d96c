"""Triangulated surfaces as a whole: their sides turned alike, and the edges where they are open."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.errors import InputError


def oriented(triangles: Indices) -> Indices:
    """Turn triangles so that neighbours run through their common edge in opposite directions.

    Parameters
    ----------
    triangles : numpy.ndarray
        (k, 3) indices of nodes.

    Returns
    -------
    numpy.ndarray
        (k, 3) the same triangles, some of them turned; of each connected part the majority stays.

    Raises
    ------
    InputError
        If an edge has more than two triangles, or the surface has one side only.

    Examples
    --------
    >>> oriented(np.array([[0, 1, 2], [1, 2, 3], [2, 3, 4], [0, 2, 4]]))
    array([[0, 1, 2],
           [2, 1, 3],
           [2, 3, 4],
           [0, 2, 4]])
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(triangles)
    first, second, alike = _neighbours(triangles)
    # every triangle twice, as it is and turned; neighbours that disagree tie it to the other's turn
    shift = np.where(alike, count, 0)
    rows = np.concatenate([first, first + count])
    columns = np.concatenate([second + shift, second + count - shift])
    graph = coo_array((np.ones(len(rows), np.int8), (rows, columns)), (2 * count, 2 * count))
    parts, label = connected_components(graph, directed=False)
    if (label[:count] == label[count:]).any():
        raise InputError("the surface has one side only, so that there is no volume inside")
    untouched = np.bincount(label[:count], minlength=parts)  # triangles that a choice leaves alone
    turned = untouched[label[count:]] > untouched[label[:count]]
    tie = untouched[label[count:]] == untouched[label[:count]]
    turned |= tie & (label[count:] < label[:count])
    out = triangles.copy()
    out[turned] = out[turned][:, [1, 0, 2]]
    return out


def open_loops(triangles: Indices) -> list[Indices]:
    """Closed loops of the edges that have one triangle, in the direction in which that runs.

    Parameters
    ----------
    triangles : numpy.ndarray
        (k, 3) of a surface turned alike, see `oriented`.

    Examples
    --------
    >>> open_loops(np.array([[0, 1, 2], [0, 2, 3]]))
    [array([0, 1, 2, 3])]
    """
    edges = _edges(triangles)
    key = np.sort(edges, axis=1)
    _, where, counts = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    ahead: dict[int, list[int]] = {}
    for a, b in edges[counts[where.ravel()] == 1].tolist():
        ahead.setdefault(a, []).append(b)
    loops = []
    while ahead:
        start = next(iter(ahead))
        loop, at = [], start
        while at in ahead:
            loop.append(at)
            targets = ahead[at]
            following = targets.pop()
            if not targets:
                del ahead[at]
            at = following
            if at == start:
                break
        loops.append(np.array(loop, dtype=np.int64))
    return loops


def _edges(triangles: Indices) -> Indices:
    """(3 k, 2) edges, those of one triangle one after the other."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def _neighbours(triangles: Indices) -> tuple[Indices, Indices, np.ndarray]:
    """Pairs of triangles with a common edge, and whether both run through it in one direction."""
    edges = _edges(triangles)
    key, forward = np.sort(edges, axis=1), edges[:, 0] < edges[:, 1]
    order = np.lexsort(key.T)
    same = (key[order[1:]] == key[order[:-1]]).all(axis=1)
    if (same[1:] & same[:-1]).any():
        at = int(np.flatnonzero(same[1:] & same[:-1])[0])
        a, b = key[order[at]].tolist()
        raise InputError(
            f"the edge between the points {a} and {b} (counted from 0) has more than two "
            "triangles, so that there is no volume inside"
        )
    one, other = order[:-1][same], order[1:][same]
    return one // 3, other // 3, forward[one] == forward[other]
