"""Hexahedra and wedges that a drag may fold inside before any corner stops it."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.meshes.measures.bezier import coefficients_of, folded
from ffdstudio.meshes.measures.blocks import CellBlock
from ffdstudio.meshes.measures.vectors import gathered, pieces
from ffdstudio.meshes.safety.halfspaces import Region


class Tender:
    """Cells of one block with a Bezier coefficient whose half-space leaves the region.

    Attributes
    ----------
    block : CellBlock
        These cells.
    vectors : numpy.ndarray
        (cells, coefficients, 3) h of each coefficient: a bound, not a limit.
    """

    def __init__(self, block: CellBlock, start: Array, influence: Array, region: Region) -> None:
        rows, vectors = [], []
        for piece in pieces(len(block.nodes)):
            h = _bounds(block[piece], start, influence)
            with np.errstate(invalid="ignore"):  # undecided ones are kept below
                out = region.outside(h.reshape(-1, 3)).reshape(h.shape[:2]).any(axis=1)
            out |= ~np.isfinite(h).all(axis=(1, 2))
            rows.append(np.flatnonzero(out) + piece.start)
            vectors.append(h[out])
        self.block = block[np.concatenate(rows)] if rows else block
        self.vectors = np.concatenate(vectors) if vectors else np.empty((0, 1, 3))
        sound = ~folded(self.block, start)
        self.block, self.vectors = self.block[sound], self.vectors[sound]

    def candidates(self, direction: Array, amplitude: float) -> CellBlock:
        """Cells that might fold inside before this amplitude."""
        with np.errstate(invalid="ignore"):
            steepest = (self.vectors @ direction).max(axis=1, initial=0.0)
            soon = ~(steepest * amplitude <= 1) if np.isfinite(amplitude) else ~(steepest <= 0)
        return self.block[soon]


def _bounds(block: CellBlock, start: Array, influence: Array) -> Array:
    """(k, coefficients, 3) vectors h of the Bezier coefficients; not finite where undecided."""
    of = coefficients_of(block.type)
    x, b = gathered(start, block.nodes), influence[block.nodes].T
    size = np.ptp(x, axis=1).max(axis=0)  # linear in D: any step does, one of its size is exact
    reach = np.abs(b).max(axis=0)
    step = np.where((size > 0) & (reach > 0), size / np.where(reach > 0, reach, 1.0), 1.0)
    values = of(x).reshape(-1, x.shape[-1])
    sign = np.sign(values.sum(axis=0))
    h = []
    for axis in range(3):
        moved = x.copy()
        moved[axis] += b * step
        h.append((of(moved).reshape(values.shape) - values) / step)
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = np.where(values * sign > 0, -np.stack(h) / values, np.inf)
    return bound.transpose(2, 1, 0)
