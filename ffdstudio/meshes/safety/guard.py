"""The live guard: how far a drag may go, in every direction, known while it is under way.

1. A drag moves each node by x0 + b D with one vector D: see `halfspaces` for why each corner
   then sets a half-space, and why few of them count.
2. A hexahedron or wedge may fold inside before its corners do. Its Bezier coefficients are
   linear in D as well; cells with one that reaches out of the region of the corners are looked
   at more closely, along the direction asked for (`interior`).
3. Limits of the solver (`limits`) are evaluated on the cells that the drag strains most
   (`solver_limits`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.meshes.measures.bezier import has_inside
from ffdstudio.meshes.measures.blocks import CellBlock, blocks_of
from ffdstudio.meshes.measures.cell_coverage import coverage
from ffdstudio.meshes.measures.corners import signs
from ffdstudio.meshes.measures.inversion import deformed
from ffdstudio.meshes.measures.vectors import pieces
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.safety.halfspaces import Region, corner_halfspaces
from ffdstudio.meshes.safety.interior import first_fold
from ffdstudio.meshes.safety.interior_candidates import Tender
from ffdstudio.meshes.safety.limits import INVERSION, Limits, Stop

if TYPE_CHECKING:
    from ffdstudio.meshes.safety.solver_limits import Strained

MARGIN = 1e-3  # an allowed drag ends this fraction before the limit
PIECE = 16384


class Guard:
    """Safe region of a drag that moves nodes by ``points + influence * D``.

    Parameters
    ----------
    mesh : Mesh
        The undeformed mesh, which tells the sign of each cell.
    points : array_like
        (n, 3) coordinates when the drag begins.
    influence : array_like
        (m,) factor b of the nodes in `rows`.
    rows : array_like
        (m,) numbers of the nodes that move, as in the engine's `Drag`.
    limits : Limits, optional
        What else must hold besides no cell inverting.

    Attributes
    ----------
    coverage : Coverage
        Which cells it knows, and which it does not.

    Raises
    ------
    InputError
        If the arrays do not fit.

    Examples
    --------
    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 2, 0]], {"triangle": [[0, 1, 2]]}, dimension=2)
    >>> guard = Guard(mesh, mesh.points, influence=[0.5], rows=[2])
    >>> guard.limit([0, -1, 0]), guard.limit([1, 0, 0])
    (4.0, inf)
    """

    def __init__(
        self,
        mesh: Mesh,
        points: ArrayLike,
        influence: ArrayLike,
        rows: ArrayLike,
        limits: Limits = INVERSION,
    ) -> None:
        start = deformed(mesh, points)
        b = _influence(len(start), influence, rows)
        blocks = blocks_of(mesh)
        rest, self._start = blocks.extended(mesh.points), blocks.extended(start)
        self._b = blocks.extended(b[:, None])[:, 0]
        up = blocks.upright(rest)
        self.coverage = coverage(mesh)
        self.region = Region()
        chosen = blocks.moved_cells(b != 0)
        moving = blocks.of_cells(chosen)
        for block in moving:
            self._collect(block, rest, up)
        self.region.thin()
        inside = [block for block in moving if has_inside(block.type)]
        inside += [block[chosen[block.cells]] for block in blocks.curved]
        self._tender = [Tender(x, self._start, self._b, self.region) for x in inside]
        self._strained: Strained | None = None
        if limits != INVERSION:
            from ffdstudio.meshes.safety.solver_limits import Strained  # loads numba

            self._strained = Strained(mesh, start, b, self.region, limits)

    def _collect(self, block: CellBlock, rest: Array, up: Array | None) -> None:
        for piece in pieces(len(block.nodes), PIECE):
            part = block[piece]
            sign = signs(part, rest, up)
            self.region.add(*corner_halfspaces(part, self._start, self._b, sign, up))

    def limit(self, direction: ArrayLike) -> float:
        """Largest t such that all D = t' * direction with t' < t are safe."""
        return self.stop(direction).amplitude

    def stop(self, direction: ArrayLike) -> Stop:
        """Where a drag along `direction` (3,) has to end, and why."""
        vector = np.asarray(direction, dtype=np.float64)
        steepest, cell = self.region.steepest(vector)
        stop = Stop(1 / steepest, "inversion", cell) if steepest > 0 else Stop(np.inf)
        for tender in self._tender:
            block = tender.candidates(vector, stop.amplitude)
            if len(block.cells):
                move = self._b[:, None] * vector
                found = first_fold(block, self._start, move, stop.amplitude)
                if found < stop.amplitude:
                    stop = Stop(found, "inversion", int(block.cells[0]))
        if self._strained is not None:
            stop = self._strained.stop(vector, stop)
        return stop

    def allowed(self, vector: ArrayLike) -> Array:
        """Return the drag (3,) itself if it is safe, else as much of it as is."""
        asked = np.asarray(vector, dtype=np.float64)
        limit = self.limit(asked) * (1 - MARGIN)
        return asked if limit >= 1 else asked * limit


def _influence(count: int, influence: ArrayLike, rows: ArrayLike) -> Array:
    """(n,) influence of all nodes."""
    values, where = np.asarray(influence, dtype=np.float64), np.asarray(rows, dtype=np.int64)
    if values.shape != where.shape or values.ndim != 1 or not np.isfinite(values).all():
        raise InputError("a guard needs one finite influence for each node that moves")
    if where.size and not (where.min() >= 0 and where.max() < count):
        raise InputError(f"a guarded node lies outside 0 to {count - 1}")
    out = np.zeros(count)
    out[where] = values
    return out
