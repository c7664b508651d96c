"""Nodes that belong together in twos: of periodic boundaries, and front and back of `empty`.

1. A file may pair nodes one by one (`Mesh.links`) or markers (`Mesh.partners`); where it tells
   nothing, two of its periodic markers are looked at, or markers with "period" or "cyclic" in
   their names. What counts is that the nodes of one lie on those of the other after a shift
   or a turn.
2. The turn is looked for about the coordinate axes through the origin, and by the order of the
   elements, which corresponds in OpenFOAM's cyclic patches and Fluent's pairs of faces.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from weakref import WeakKeyDictionary

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.planes import planes_of, size_of

WORDS = ("period", "cyclic")
SLACK = 1e-6  # of the mesh's size: how near partners lie to each other after the motion
Motion = tuple[Array, Array]  # (3, 3) turn and (3,) shift


@dataclass(frozen=True, eq=False)
class Pair:
    """Nodes `first` of one marker with their partners `second`: ``turn @ x + shift``.

    Attributes
    ----------
    names : tuple of str
        Of the two markers; one name if both are parts of it.
    first, second : numpy.ndarray
        (k,) node indices.
    turn, shift : numpy.ndarray
        (3, 3) and (3,).
    opposite : bool
        Whether they are front and back of a plane case rather than periodic.
    """

    names: tuple[str, ...]
    first: Indices
    second: Indices
    turn: Array
    shift: Array
    opposite: bool = False

    def misses(self, points: Array) -> Array:
        """(k,) how far partners are from where they belong, given all nodes (n, 3)."""
        wanted = points[self.first] @ self.turn.T + self.shift
        return np.asarray(np.linalg.norm(points[self.second] - wanted, axis=1))


_known: WeakKeyDictionary[Mesh, tuple[Pair, ...]] = WeakKeyDictionary()


def pairs_of(mesh: Mesh) -> tuple[Pair, ...]:
    """Pairs of boundaries whose nodes have to stay partners.

    Examples
    --------
    >>> points = [[0, 0, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]]
    >>> markers = {"period_a": {"line": [[0, 1]]}, "period_b": {"line": [[3, 2]]}}
    >>> [pair] = pairs_of(Mesh(points, {"quad": [[0, 2, 3, 1]]}, markers, dimension=2))
    >>> pair.first.tolist(), pair.second.tolist(), pair.shift
    ([0, 1], [2, 3], array([2., 0., 0.]))
    """
    if mesh not in _known:
        linked = tuple(_linked(mesh))
        _known[mesh] = (*linked, *_periodic(mesh, linked), *_opposite(mesh))
    return _known[mesh]


def _linked(mesh: Mesh) -> Iterator[Pair]:
    """Pairs of nodes that the file states, with the motion that fits them best."""
    slack = SLACK * size_of(mesh)
    for link in mesh.links:
        if (link.first == link.second).all():
            continue
        a, b = mesh.points[link.first], mesh.points[link.second]
        pairs = [Pair(link.names, link.first, link.second, *m) for m in _usual_motions(mesh, a, b)]
        fits = (pair for pair in pairs if pair.misses(mesh.points).max() <= slack)
        yield next(fits, pairs[-1])


def _periodic(mesh: Mesh, linked: tuple[Pair, ...]) -> Iterator[Pair]:
    known = {name for pair in linked for name in pair.names}
    free = [name for name in mesh.boundaries if _is_periodic(mesh, name) and name not in known]
    for one, other in (*mesh.partners.items(), *combinations(free, 2)):
        if one not in free or other not in free or one == other:
            continue
        pair = _matched(mesh, (one, other), mesh.marker_nodes(one), mesh.marker_nodes(other))
        if pair is not None:
            free = [name for name in free if name not in (one, other)]
            yield pair


def _is_periodic(mesh: Mesh, name: str) -> bool:
    kind = mesh.kinds.get(name, "")
    named = any(word in f"{name} {kind}".lower() for word in WORDS)
    return kind in ("periodic", "wedge") or named


def _opposite(mesh: Mesh) -> Iterator[Pair]:
    """Front and back: two parallel planes that are `empty`."""
    empty = [plane for plane in planes_of(mesh) if plane.kind == "empty"]
    for front, back in combinations(empty, 2):
        if len(front.nodes) == len(back.nodes) and abs(front.normal @ back.normal) > 1 - 1e-9:
            names = tuple(dict.fromkeys((front.name, back.name)))
            pair = _matched(mesh, names, front.nodes, back.nodes, opposite=True)
            if pair is not None:
                yield pair


def _matched(
    mesh: Mesh, names: tuple[str, ...], first: Indices, second: Indices, opposite: bool = False
) -> Pair | None:
    """Partners by the first motion that takes the nodes of one side onto those of the other."""
    from scipy.spatial import cKDTree

    if len(first) != len(second) or not len(first):
        return None
    a, b = mesh.points[first], mesh.points[second]
    tree, slack = cKDTree(b), SLACK * size_of(mesh)
    for turn, shift in _motions(mesh, names, a, b):
        distance, index = tree.query(a @ turn.T + shift, distance_upper_bound=slack)
        if np.isfinite(distance).all() and len(np.unique(index)) == len(first):
            return Pair(names, first, second[index], turn, shift, opposite)
    return None


def _motions(mesh: Mesh, names: tuple[str, ...], a: Array, b: Array) -> Iterator[Motion]:
    *usual, _ = _usual_motions(mesh, a, b)
    yield from usual
    if len(names) == 2:
        centres = [_centres(mesh, name) for name in names]
        if len(centres[0]) == len(centres[1]) > 1:
            yield _rigid(mesh, *centres)


def _usual_motions(mesh: Mesh, a: Array, b: Array) -> list[Motion]:
    """Shift, turns about the axes, and the nearest motion if (k, 3) points correspond."""
    middles = a.mean(axis=0), b.mean(axis=0)
    turns = [(_turn(axis, *middles), np.zeros(3)) for axis in range(3)]
    return [(np.eye(3), middles[1] - middles[0]), *turns, _rigid(mesh, a, b)]


def _turn(axis: int, a: Array, b: Array) -> Array:
    """Turn about a coordinate axis that takes the direction of a to that of b."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    angle = np.arctan2(b[k], b[j]) - np.arctan2(a[k], a[j])
    turn = np.eye(3)
    turn[[j, j, k, k], [j, k, j, k]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
    return turn


def _centres(mesh: Mesh, name: str) -> Array:
    parts = [mesh.points[nodes].mean(axis=1) for nodes in mesh.markers[name].values()]
    return np.concatenate(parts)


def _rigid(mesh: Mesh, a: Array, b: Array) -> Motion:
    """Turn and shift nearest to taking (k, 3) points a to b (Kabsch's algorithm)."""
    k = min(len(a), len(b))
    axes = mesh.dimension  # the turn of a plane mesh stays in its plane
    c, d = a[:k] - a[:k].mean(axis=0), b[:k] - b[:k].mean(axis=0)
    u, _, v = np.linalg.svd(c[:, :axes].T @ d[:, :axes])
    signs = np.ones(axes)
    signs[-1] = np.sign(np.linalg.det(u) * np.linalg.det(v))
    turn = np.eye(3)
    turn[:axes, :axes] = v.T @ np.diag(signs) @ u.T
    return turn, b[:k].mean(axis=0) - turn @ a[:k].mean(axis=0)
