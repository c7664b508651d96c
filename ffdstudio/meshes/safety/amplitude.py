"""The exact safe amplitude: how far a displacement can go before the first cell inverts.

1. With x0 + t d a corner Jacobian is a polynomial in t, cubic in space and quadratic in a
   plane: the first inversion is the smallest positive root over all corners (`roots`).
2. Signs are those of the undeformed mesh and corners without volume are not judged, exactly as
   `measures.inverted` has it.
3. One compiled pass (`sweep`) bounds that polynomial by the end found so far; the roots are
   sought of what is left alone.
4. A hexahedron or wedge may fold inside before a corner does: `interior` looks for that in
   the amplitudes that the corners leave.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.measures.bezier import has_inside
from ffdstudio.meshes.measures.blocks import CellBlock, blocks_of
from ffdstudio.meshes.measures.corners import ROUNDING, edges, signs, unit
from ffdstudio.meshes.measures.inversion import deformed
from ffdstudio.meshes.measures.sweep import Sweep
from ffdstudio.meshes.measures.vectors import cross, dot, gathered, length, pieces, triple
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.safety.interior import first_fold
from ffdstudio.meshes.safety.roots import smallest

SAMPLE = 4096  # cells that give the first end


def safe_amplitude(mesh: Mesh, displacement: ArrayLike, points: ArrayLike | None = None) -> float:
    """Largest t such that no cell of ``points + t' * displacement`` is inverted for t' < t.

    Parameters
    ----------
    mesh : Mesh
        The undeformed mesh, which tells the sign of each cell.
    displacement : array_like
        (n, 3) in the unit of the mesh.
    points : array_like, optional
        (n, 3) where the displacement starts; by default the undeformed coordinates. Corners
        inverted there already are not counted again.

    Returns
    -------
    float
        Infinity if no amplitude inverts a cell.

    Raises
    ------
    InputError
        If the arrays do not fit the mesh or a displacement is not finite.

    Examples
    --------
    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 2, 0]], {"triangle": [[0, 1, 2]]}, dimension=2)
    >>> safe_amplitude(mesh, [[0, 0, 0], [0, 0, 0], [0, -1, 0]])
    2.0
    """
    move, start = deformed(mesh, displacement), deformed(mesh, points)
    if not np.isfinite(move).all():
        raise InputError("a displacement is not a finite number")
    blocks = blocks_of(mesh)
    rest, start, far = (blocks.extended(a) for a in (mesh.points, start, move))
    if start is not rest and np.array_equal(start, rest):
        start = rest
    if blocks.flat:
        far = far * [1, 1, 0]
    sweep = Sweep(rest, blocks.spread((move != 0).any(axis=1)), blocks.flat)
    search = _Search(sweep, start, far, blocks.upright(rest))
    for block in blocks.blocks:
        search.corners(block)
    for block in blocks.blocks:
        search.inside(block)
    for block in blocks.curved:
        search.look_into(block[np.flatnonzero(sweep.moved[block.nodes].any(axis=1))])
    return search.limit


class _Search:
    """The earliest end found so far: what cannot end earlier is passed over."""

    def __init__(self, sweep: Sweep, start: Array, move: Array, up: Array | None) -> None:
        self.sweep, self.start, self.move, self.up = sweep, start, move, up
        self.limit = np.inf
        self._doubts: dict[int, list[Indices]] = {}

    def corners(self, block: CellBlock) -> None:
        """Look at the corners of cells; at some of them first, for an end to begin with."""
        step = max(len(block.nodes) // SAMPLE, 1)
        self._solve(block[::step])
        rows = self._doubts.setdefault(id(block), [])
        for corner, inside in self.sweep.doubtful(block, self.start, self.move, lambda: self.limit):
            self._solve(block[corner])
            rows.append(inside)

    def _solve(self, block: CellBlock) -> None:
        found = _corners(block, self.sweep.rest, self.start, self.move, self.up)
        self.limit = min(self.limit, found)

    def inside(self, block: CellBlock) -> None:
        """Look into the hexahedra and wedges that are not known to be valid up to the limit."""
        if has_inside(block.type):
            rows = np.concatenate([np.empty(0, dtype=np.int64), *self._doubts[id(block)]])
            self.look_into(block[rows])

    def look_into(self, block: CellBlock) -> None:
        """Find the first of these cells that folds inside."""
        if len(block.cells):
            self.limit = first_fold(block, self.start, self.move, self.limit)


def _corners(block: CellBlock, rest: Array, start: Array, move: Array, up: Array | None) -> float:
    """Smallest amplitude at which a corner of these cells loses its volume."""
    limit = np.inf
    for piece in pieces(len(block.nodes), 65536):
        part = block[piece]
        sign = signs(part, rest, up)
        x, d = gathered(start, part.nodes), gathered(move, part.nodes)
        upright = None if up is None else gathered(up, part.nodes)
        for i, corner in enumerate(block.corners):
            normal = None if upright is None else unit(cross(*edges(upright, corner)))
            e, f = edges(x, corner), edges(d, corner)
            terms, noise = np.stack(polynomial(e, f, normal)) * sign[i], rounding(e, f)
            chosen = terms[0] > 0
            c0, c1, c2, c3 = terms[:, chosen]
            limit = min(limit, smallest(c0, c1, c2, c3, noise[:, chosen]))
    return limit


def rounding(e: list[Array], f: list[Array]) -> Array:
    """(3, k) how large c1, c2 and c3 of `polynomial` may be by rounding of their sums alone."""
    size, move = [length(v) for v in e], [length(v) for v in f]
    if len(e) == 2:
        first, second, third = size[0] * move[1] + size[1] * move[0], move[0] * move[1], 0 * size[0]
    else:
        (a, b, c), (u, v, w) = size, move
        first, second, third = (
            u * b * c + a * v * c + a * b * w,
            a * v * w + u * b * w + u * v * c,
            u * v * w,
        )
    return ROUNDING * np.stack([first, second, third])


def polynomial(e: list[Array], f: list[Array], normal: Array | None) -> list[Array]:
    """Coefficients c0 to c3 in t of the Jacobian of the edges e + t f."""
    if len(e) == 3:
        (e1, e2, e3), (f1, f2, f3) = e, f
        ee, ff = cross(e2, e3), cross(f2, f3)
        ef = cross(e2, f3) + cross(f2, e3)
        return [
            dot(e1, ee),
            dot(f1, ee) + dot(e1, ef),
            dot(f1, ef) + dot(e1, ff),
            triple(f1, f2, f3),
        ]
    (e1, e2), (f1, f2) = e, f
    terms = [cross(e1, e2), cross(f1, e2) + cross(e1, f2), cross(f1, f2)]
    flat = [t[2] if normal is None else dot(t, normal) for t in terms]
    return [*flat, np.zeros_like(flat[0])]
