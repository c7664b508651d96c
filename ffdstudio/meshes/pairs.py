"""Nodes that belong together in twos: of periodic boundaries, and front and back of `empty`.

1. Partners are told by the file (`Mesh.partners`) or are two of its periodic markers; where it
   tells nothing, markers with "period" or "cyclic" in their names. What counts is that the
   nodes of one lie on those of the other after a shift or a turn.
2. The turn is looked for about the coordinate axes through the origin, and by the order of the
   elements, which corresponds in OpenFOAM's cyclic patches.
3. SU2 keeps copies of nodes in the marker SEND_RECEIVE: those sent, then those received.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from weakref import WeakKeyDictionary

import numpy as np

from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.planes import planes_of, size_of
from ffdstudio.meshes.topology import Array, Indices

WORDS = ("period", "cyclic")
HALO = "SEND_RECEIVE"
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
        _known[mesh] = (*_periodic(mesh), *_halos(mesh), *_opposite(mesh))
    return _known[mesh]


def _periodic(mesh: Mesh) -> Iterator[Pair]:
    free = [name for name in mesh.boundaries if _is_periodic(mesh, name)]
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


def _halos(mesh: Mesh) -> Iterator[Pair]:
    nodes = mesh.markers.get(HALO, {}).get("vertex", np.empty((0, 1), dtype=np.int64)).ravel()
    half = len(nodes) // 2
    if not half or len(nodes) % 2:
        return
    first, second = nodes[:half], nodes[half:]
    a, b = mesh.points[first], mesh.points[second]
    pair = Pair((HALO,), first, second, *_rigid(a, b))
    if (first != second).any() and pair.misses(mesh.points).max() <= SLACK * size_of(mesh):
        yield pair


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
    yield np.eye(3), b.mean(axis=0) - a.mean(axis=0)
    for axis in range(3):
        yield _turn(axis, a.mean(axis=0), b.mean(axis=0)), np.zeros(3)
    if len(names) == 2:
        centres = [_centres(mesh, name) for name in names]
        if len(centres[0]) == len(centres[1]) > 2:
            yield _rigid(*centres)


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


def _rigid(a: Array, b: Array) -> Motion:
    """Turn and shift nearest to taking (k, 3) points a to b (Kabsch's algorithm)."""
    u, _, v = np.linalg.svd((a - a.mean(axis=0)).T @ (b - b.mean(axis=0)))
    sign = np.sign(np.linalg.det(u) * np.linalg.det(v))
    turn = v.T @ np.diag([1, 1, sign]) @ u.T
    return turn, b.mean(axis=0) - turn @ a.mean(axis=0)
