"""The loops over points, compiled by numba; the only place for it besides the inversion.

1. A factory freezes the degrees as constants of ONE function. LLVM then unrolls the sum over
   a slab of coefficients and vectorises over the points; and numba's disk cache, whose key
   holds the constants, hits in the next process. It would not if the function called another
   compiled one, or ran with numba's own threads.
2. The loop over polynomials and slabs is a single one with a length known only at run time:
   nested ones are unrolled too early, and the loop over points is then no longer innermost.
3. Multiply-adds are fused by name (`_fma`), never at LLVM's discretion: the vector body and the
   scalar remainder of a loop, and thus any two places in an array, round alike.
4. Blocks are filled up to whole vectors with whatever the buffers hold; only the real points
   are read back.
5. LLVM takes half-wide vectors by default where it could have whole ones (AVX-512); a function
   attribute asks for them, which llvmlite passes on though it is not in its list of known ones.
   With sums of 64 terms a point they are worth some 7 %, elsewhere nothing changes.
6. Several threads may run a kernel at once: it owns its buffers, and each point belongs to one
   piece.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

from ffdstudio.compiling import compiled

BLOCK = 256  # points in a block: its buffers fill a good part of the first-level cache
_LANES = 32  # four AVX-512 vectors, the most that LLVM interleaves


def _generate_fma(context: Any, a: Any, b: Any, c: Any) -> Any:
    """Type and code of ``a * b + c``, rounded once."""
    double = types.float64

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')  # see 5
        return builder.fma(*arguments)

    return double(double, double, double), generate


_fma: Any = intrinsic(_generate_fma)


@cache
def displace(p: int, q: int, r: int) -> Any:
    """Kernel that adds the displacements of a `polynomials.Table` to the rows of `out`."""

    def displace(
        first_piece: int,
        last_piece: int,
        pieces: np.ndarray,  # (pieces, 5) rows to copy; base row; segments
        starts: np.ndarray,
        slots: np.ndarray,  # (cells,) place in the table, -1 for cells at rest
        order: np.ndarray,
        u: np.ndarray,
        ends: np.ndarray,
        kinds: np.ndarray,
        mask: np.ndarray,
        coefficients: np.ndarray,  # (cells, fields, slabs, slab): flat slabs
        step: float,
        points: np.ndarray,
        copy: bool,  # rows to copy begin with their point, or with zero
        out: np.ndarray,
    ) -> None:
        t = np.zeros((3, BLOCK))
        t0, t1, t2 = t[0], t[1], t[2]
        directions = len(u)
        row = np.zeros(BLOCK, dtype=np.uint64)
        values = np.zeros((8, BLOCK))
        for piece in range(first_piece, last_piece):
            for i in range(pieces[piece, 0], pieces[piece, 1]):
                if copy:
                    out[i, 0] = points[i, 0]
                    out[i, 1] = points[i, 1]
                    out[i, 2] = points[i, 2]
                else:
                    for k in range(out.shape[1]):
                        out[i, k] = 0.0
            base = np.uint64(pieces[piece, 2])
            for segment in range(pieces[piece, 3], pieces[piece, 4]):
                cell = slots[segment % len(slots)]
                if cell < 0 or mask[cell] == 0:
                    continue
                fields = kinds[cell]
                for start in range(starts[segment], starts[segment + 1], BLOCK):
                    count = min(BLOCK, starts[segment + 1] - start)
                    full = (count + _LANES - 1) // _LANES * _LANES
                    rows = order[start : start + count]
                    for i in range(count):
                        row[i] = base + rows[i]
                    # local coordinates in [-1, 1]; on a knot any will do
                    for k in range(directions):
                        low, high = ends[cell, k, 0], ends[cell, k, 1]
                        scale = 1.0 / (high - low) if high > low else 0.0
                        uk, tk = u[k, start : start + count], t[k]
                        for i in range(count):
                            tk[i] = ((uk[i] - low) - (high - uk[i])) * scale
                    values[:fields, :full] = 0.0
                    # Horner in the first direction over slabs of the other two
                    for slab in range(fields * (p + 1)):
                        field = slab // (p + 1)
                        if field % 4 < 3 and not mask[cell] >> field % 4 & 1:
                            continue
                        value = values[field]
                        c = coefficients[cell, field, p - slab % (p + 1)]
                        for i in range(full):
                            y = 0.0
                            for b in range(q, -1, -1):
                                z = c[b * (r + 1) + r]
                                for g in range(r - 1, -1, -1):
                                    z = _fma(z, t2[i], c[b * (r + 1) + g])
                                y = _fma(y, t1[i], z)
                            value[i] = _fma(value[i], t0[i], y)
                    if fields == 4:
                        for i in range(full):
                            share = 1.0 / values[3, i]
                            values[0, i] *= share
                            values[1, i] *= share
                            values[2, i] *= share
                    elif fields == 8:
                        for i in range(full):
                            turn = values[7, i] / values[3, i]
                            share = 1.0 / (values[3, i] + step * values[7, i])
                            values[0, i] = (values[0, i] - values[4, i] * turn) * share
                            values[1, i] = (values[1, i] - values[5, i] * turn) * share
                            values[2, i] = (values[2, i] - values[6, i] * turn) * share
                    if mask[cell] == 7 and out.shape[1] == 3:  # each row once: it comes from afar
                        for i in range(count):
                            out[row[i], 0] += values[0, i]
                            out[row[i], 1] += values[1, i]
                            out[row[i], 2] += values[2, i]
                        continue
                    for k in range(out.shape[1]):
                        if mask[cell] >> k & 1:
                            for i in range(count):
                                out[row[i], k] += values[k, i]

    return compiled(displace)


@cache
def move() -> Any:
    """Kernel of a drag: rows of `out` become start + influence * vector."""

    def move(
        first: int,
        last: int,
        rows: np.ndarray,
        start: np.ndarray,
        influence: np.ndarray,
        vector: np.ndarray,
        out: np.ndarray,
    ) -> None:
        x, y, z = vector[0], vector[1], vector[2]
        for i in range(first, last):
            row = np.uint64(rows[i])
            b = influence[i]
            out[row, 0] = start[i, 0] + b * x
            out[row, 1] = start[i, 1] + b * y
            out[row, 2] = start[i, 2] + b * z

    return compiled(move)
