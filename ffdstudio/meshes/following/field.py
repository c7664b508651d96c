"""The weighted field of moving sources, at any number of targets: set up once, evaluated often.

1. What a box of targets sees depends on how near it is to the sources: beside a wall, where
   cells may be a millionth of a chord high, the error has to be small against the height.
   So it is bounded by a share (`TOLERANCE`) of the distance from the nearest source.
2. The least sum of weights in a box comes from a first, coarse pass.
"""

from __future__ import annotations

import numpy as np

from ffdstudio import threads
from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.following import kernels
from ffdstudio.meshes.following.tree import runs

BOX, CLUSTER = 48, 8  # targets in a box, sources in the smallest cluster
COARSE, OPENING = 0.8, 0.5  # radius of a cluster over its distance
TOLERANCE = 5e-3  # error of a weight, over the distance from the nearest source in near lengths
PARTS = 8  # whose sums are added in order: not by the number of cores
PIECE = 256  # boxes in a piece of work


class Field:
    """Inverse distance weights between sources and targets.

    Parameters
    ----------
    places, areas : numpy.ndarray
        (s, 3) and (s,) of the sources.
    targets : numpy.ndarray
        (t, 3), none of them where a source is.
    near : float
        Distance at which the fifth power takes over from the third.
    """

    def __init__(self, places: Array, areas: Array, targets: Array, near: float) -> None:
        self._sources, self._boxes = runs(places, CLUSTER), runs(targets, BOX)
        self.near, self.count = near**2, len(places)
        self._targets = np.ascontiguousarray(targets[self._boxes.order])
        clusters = len(self._sources.begin)
        self.items = np.empty((clusters + len(places), 4))
        self.items[clusters:, :3] = places[self._sources.order]
        self.items[clusters:, 3] = areas[self._sources.order]
        self._radii = np.empty(clusters)
        kernels.gather(
            self._sources.begin, self._sources.end, self._sources.children,
            self.items[clusters:, :3].copy(), self.items[clusters:, 3].copy(),
            self.items, self._radii,
        )  # fmt: skip
        self._leaves = self._boxes.leaves
        free = np.full(len(self._boxes.begin), np.inf)
        self._look(COARSE, free)
        self._look(OPENING, self._least(places))

    def displacements(self, matrices: Array, vectors: Array) -> Array:
        """(t, 3) of the targets, given the affine field (s, 3, 3), (s, 3) about each source."""
        fields = np.empty((len(self.items), kernels.FIELD))
        clusters, order = len(self._radii), self._sources.order
        fields[clusters:, :9] = matrices[order].reshape(-1, 9)
        fields[clusters:, 9:] = vectors[order]
        kernels.collect(*self._clusters, self.items, fields)
        out = np.empty_like(self._targets)
        self._shared(kernels.displace, self.items, fields, self.near, out)
        placed = np.empty_like(out)
        placed[self._boxes.order] = out
        return placed

    def pull(self, gradient: Array) -> tuple[Array, Array]:
        """Derivatives by the sources' fields, from that by the targets' places (t, 3)."""
        ordered = np.ascontiguousarray(gradient[self._boxes.order])
        parts = np.array_split(self._leaves, PARTS)
        sums: list[Array | None] = [None] * PARTS

        def one(number: int) -> None:
            out = np.zeros((len(self.items), kernels.FIELD))
            kernels.pull(parts[number], *self._seen, self.items, ordered, self.near, out)
            sums[number] = out

        threads.for_each(one, range(PARTS))
        fields = np.zeros((len(self.items), kernels.FIELD))
        for part in sums:
            assert part is not None
            fields += part
        kernels.spread(*self._clusters, self.items, fields)
        own = np.empty((self.count, kernels.FIELD))
        own[self._sources.order] = fields[len(self._radii) :]
        return own[:, :9].reshape(-1, 3, 3), own[:, 9:]

    @property
    def _clusters(self) -> tuple[Indices, Indices, Indices]:
        return self._sources.children, self._sources.begin, self._sources.end

    @property
    def _seen(self) -> tuple[Indices, Indices, Array, Indices, np.ndarray]:
        return self._boxes.begin, self._boxes.end, self._targets, self._starts, self._items_seen

    def _shared(self, kernel: object, *arguments: object) -> None:
        pieces = np.array_split(self._leaves, max(len(self._leaves) // PIECE, 1))
        threads.for_each(lambda piece: kernel(piece, *self._seen, *arguments), pieces)  # type: ignore[operator]

    def _look(self, opening: float, least: Array) -> None:
        """Find what each box sees."""
        pieces = np.array_split(self._leaves, max(len(self._leaves) // PIECE, 1))
        found: dict[int, tuple[Indices, np.ndarray]] = {}

        def one(number: int) -> None:
            boxes, room = pieces[number], 64 * len(pieces[number]) + len(self.items)
            counts = np.empty(len(boxes), dtype=np.int64)
            while True:
                out = np.empty(room, dtype=np.int32)
                many = kernels.seen(
                    boxes, self._boxes.begin, self._boxes.end, self._targets, *self._clusters,
                    self.items, self._radii, self.near, opening, least, counts, out,
                )  # fmt: skip
                if many >= 0:
                    break
                room *= 2
            found[number] = counts, out[:many].copy()

        threads.for_each(one, range(len(pieces)))
        counts = np.zeros(len(self._boxes.begin) + 1, dtype=np.int64)
        counts[self._leaves + 1] = np.concatenate([found[n][0] for n in range(len(pieces))])
        self._starts = np.cumsum(counts)
        self._items_seen: np.ndarray = np.concatenate([found[n][1] for n in range(len(pieces))])

    def _least(self, places: Array) -> Array:
        """(boxes,) largest error of one weight that each box may have."""
        from scipy.spatial import cKDTree

        sums = np.empty(len(self._targets))
        self._shared(kernels.weights, self.items, self.near, sums)
        nearest = cKDTree(places).query(self._targets, workers=threads.count())[0]
        begin = self._boxes.begin[self._leaves]
        share = TOLERANCE * np.minimum(np.minimum.reduceat(nearest, begin) / np.sqrt(self.near), 1)
        least = np.full(len(self._boxes.begin), np.inf)
        least[self._leaves] = share * np.minimum.reduceat(sums, begin)
        return least
