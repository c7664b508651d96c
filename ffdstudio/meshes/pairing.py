"""Faces that two cells share, found for display, quality and topology checks alike.

1. Faces are compared within buckets by their smallest node (`pairing_kernels`): nothing is
   sorted, and tetrahedra take some 36 bytes each at the peak.
2. Equal are faces of the same set of nodes, whatever the order in which each cell lists them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffdstudio import threads
from ffdstudio.aliases import AnyArray, Indices

Table = tuple[tuple[int, ...], ...]
Sides = tuple[AnyArray, Table]  # nodes (k, corners) of cells, and their faces by corner
ALONE, MANY = -1, -2
CHUNK = 1 << 18
WORKERS = 4  # each has places of its own in every bucket


@dataclass(frozen=True, eq=False)
class Buckets:
    """All faces of cells: ``first[n]`` to ``first[n + 1]`` have n as smallest node."""

    first: AnyArray
    keys: AnyArray
    extra: AnyArray
    ids: AnyArray

    @property
    def ranges(self) -> list[tuple[int, int]]:
        """Ranges of nodes to share among threads."""
        return _ranges(len(self.first) - 1, CHUNK)


def outer(sides: Sequence[Sides]) -> list[list[Indices]]:
    """Rows of the cells whose face is shared with no other one: by cells, by face of their table.

    Examples
    --------
    >>> two = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
    >>> [rows.tolist() for rows in outer([(two, ((0, 2, 1), (1, 2, 3)))])[0]]
    [[0], [1]]
    """
    from ffdstudio.meshes.pairing_kernels import marked, matched

    found = _filled(sides, numbered=False)
    state, none = np.empty(len(found.keys), dtype=np.uint8), np.empty(0, dtype=np.int64)
    given = found.first, found.keys, found.extra, found.ids, state, none, none
    threads.for_each(lambda part: matched(*part, *given), found.ranges)
    has = np.zeros(len(found.first), dtype=np.uint8)
    threads.for_each(lambda part: marked(*part, found.first, state, has), found.ranges)
    return [
        [_alone(nodes, _padded(table), face, found, state, has) for face in range(len(table))]
        for nodes, table in sides
    ]


def _alone(
    nodes: AnyArray,
    table: AnyArray,
    face: int,
    found: Buckets,
    state: AnyArray,
    has: AnyArray,
) -> Indices:
    from ffdstudio.meshes.pairing_kernels import alone

    parts: dict[int, Indices] = {}

    def work(part: tuple[int, int]) -> None:
        out = np.empty(part[1] - part[0], dtype=np.int64)
        given = nodes, table, face, found.first, found.keys, found.extra, state, has
        parts[part[0]] = out[: alone(*part, *given, out)].copy()

    threads.for_each(work, _ranges(len(nodes), CHUNK))
    return np.concatenate([parts[k] for k in sorted(parts)] or [np.empty(0, dtype=np.int64)])


def partners(sides: Sequence[Sides]) -> Indices:
    """Number of the equal face for every face of cells: `ALONE`, or `MANY` for one of several.

    Faces are numbered cells after cells, face after face of their table, row after row.

    Examples
    --------
    >>> partners([(np.array([[0, 1, 2, 3], [1, 2, 3, 4]]), ((0, 2, 1), (1, 2, 3)))])
    array([-1,  2,  1, -1])
    """
    from ffdstudio.meshes.pairing_kernels import matched

    found = _filled(sides, numbered=True)
    state = np.empty(len(found.keys), dtype=np.uint8)
    partner = np.empty(len(found.ids), dtype=np.int64)
    given = found.first, found.keys, found.extra, found.ids, state, partner
    names = np.array([ALONE, MANY])
    threads.for_each(lambda part: matched(*part, *given, names), found.ranges)
    return partner


def loop_partners(nodes: Indices, offsets: Indices) -> Indices:
    """Number of the equal face for faces of any size, one after the other; see `partners`.

    Examples
    --------
    >>> loop_partners(np.array([0, 1, 2, 3, 4, 3, 2, 1, 0, 4]), np.array([0, 5, 10]))
    array([1, 0])
    """
    from ffdstudio.meshes.pairing_kernels import looped, loops_matched

    faces = len(offsets) - 1
    partner = np.full(faces, ALONE, dtype=np.int64)
    if faces:
        numbers = np.random.default_rng(0).integers(2**63, size=nodes.max(initial=0) + 1)
        total = np.empty(faces, dtype=np.int64)
        looped(nodes, offsets, numbers, total)
        order = np.argsort(total, kind="stable")
        loops_matched(order, nodes, offsets, total, partner, np.array([ALONE, MANY]))
    return partner


def _filled(sides: Sequence[Sides], numbered: bool) -> Buckets:
    from ffdstudio.meshes.pairing_kernels import counted, filled

    tables = [(nodes, _padded(table)) for nodes, table in sides]
    size = 1 + max((int(nodes.max(initial=-1)) for nodes, _ in tables), default=-1)
    faces = sum(len(nodes) * len(table) for nodes, table in sides)
    workers = min(threads.count(), WORKERS) if faces > 20_000 else 1
    whole = np.int32 if max(size, faces) < 2**31 else np.int64
    at = np.zeros((workers, size), dtype=whole)
    for nodes, table in tables:
        shares = _shares(len(nodes), workers)
        threads.for_each(lambda s: counted(*s[1:], nodes, table, at[s[0]]), shares)  # noqa: B023
    first = np.zeros(size + 1, dtype=np.int64)
    np.cumsum(at.sum(axis=0), out=first[1:])
    at[:] = (np.cumsum(at, axis=0) - at) + first[:-1]
    quads = any(len(face) > 3 for _, table in sides for face in table)
    keys = np.empty(faces, dtype=np.int64)
    extra = np.empty(faces if quads else 0, dtype=whole)
    ids = np.empty(faces if numbered else 0, dtype=whole)
    start = 0
    for nodes, table in tables:
        given = start, keys, extra, ids
        shares = _shares(len(nodes), workers)
        threads.for_each(
            lambda s: filled(*s[1:], nodes, table, given[0], at[s[0]], *given[1:]),  # noqa: B023
            shares,
        )
        start += len(nodes) * len(table)
    return Buckets(first, keys, extra, ids)


def _padded(table: Table) -> AnyArray:
    """(faces, 4) faces by corner; triangles and edges repeat their last one."""
    return np.array([[*face, face[-1], face[-1]][:4] for face in table], dtype=np.int64)


def _shares(rows: int, workers: int) -> list[tuple[int, int, int]]:
    """Number, begin and end of the rows that each worker takes."""
    ends = [rows * k // workers for k in range(workers + 1)]
    return [(k, ends[k], ends[k + 1]) for k in range(workers)]


def _ranges(size: int, step: int) -> list[tuple[int, int]]:
    return [(i, min(i + step, size)) for i in range(0, size, step)]
