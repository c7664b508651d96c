"""Sums of sensitivities times monomials, compiled by numba: the transpose of `kernels.displace`.

1. The sum over the points of a cell, ``s_f t0^i t1^j t2^k``, is a product of two thin matrices,
   (fields and powers of the first direction) x points by points x (powers of the others). It is
   taken over blocks of points whose monomials lie in the first-level cache.
2. Sums may be taken in any order within a block, so that LLVM uses whole vectors. That order
   is fixed when the kernel is compiled; which blocks there are depends on the points alone.
3. The degrees are constants of the function, for the reasons given in `kernels`.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ffdstudio.compiling import compiled

BLOCK = 128  # points


def columns(q: int, r: int) -> int:
    """Monomials of the last two directions, rounded up to pairs."""
    return 2 * (((q + 1) * (r + 1) + 1) // 2)


@cache
def moments(p: int, q: int, r: int, rational: bool) -> Any:
    """Kernel that adds up s / W, and s . R / W if rational, times monomials, by cell."""
    count = (q + 1) * (r + 1)
    wide = columns(q, r)

    def moments(
        first_piece: int,
        last_piece: int,
        pieces: np.ndarray,
        starts: np.ndarray,
        slots: np.ndarray,
        order: np.ndarray,
        u: np.ndarray,  # (d, m)
        ends: np.ndarray,  # (cells, d, 2)
        net: np.ndarray,  # (cells, 4, p + 1, count): W and N; no cells if W is 1
        sensitivities: np.ndarray,  # (n, 3)
        sums: np.ndarray,  # (cells, 4, p + 1, wide): s / W and s . R / W
    ) -> None:
        t = np.zeros((3, BLOCK))
        t0, t1, t2 = t[0], t[1], t[2]
        s = np.zeros((4, BLOCK))
        powers = np.zeros((wide, BLOCK))
        point = np.zeros((4, BLOCK))  # W and N
        value = np.zeros(BLOCK)
        directions = len(u)
        for piece in range(first_piece, last_piece):
            base = np.uint64(pieces[piece, 2])
            for segment in range(pieces[piece, 3], pieces[piece, 4]):
                cell = slots[segment % len(slots)]
                if cell < 0:
                    continue
                for start in range(starts[segment], starts[segment + 1], BLOCK):
                    size = min(BLOCK, starts[segment + 1] - start)
                    for i in range(size):
                        row = base + np.uint64(order[start + i])
                        s[0, i] = sensitivities[row, 0]
                        s[1, i] = sensitivities[row, 1]
                        s[2, i] = sensitivities[row, 2]
                    for f in range(3):  # what a block lacks counts nothing
                        for i in range(size, BLOCK):
                            s[f, i] = 0.0
                    for k in range(directions):
                        low, high = ends[cell, k, 0], ends[cell, k, 1]
                        scale = 1.0 / (high - low) if high > low else 0.0
                        uk, tk = u[k, start : start + size], t[k]
                        for i in range(size):
                            tk[i] = ((uk[i] - low) - (high - uk[i])) * scale
                    for i in range(BLOCK):
                        powers[0, i] = 1.0
                    for k in range(1, r + 1):
                        a, b = powers[k - 1], powers[k]
                        for i in range(BLOCK):
                            b[i] = a[i] * t2[i]
                    for c in range(r + 1, count):
                        a, b = powers[c - r - 1], powers[c]
                        for i in range(BLOCK):
                            b[i] = a[i] * t1[i]
                    if rational:
                        for f in range(4):
                            for i in range(BLOCK):
                                point[f, i] = 0.0
                        for slab in range(4 * (p + 1)):
                            c = net[cell, slab // (p + 1), p - slab % (p + 1)]
                            for i in range(BLOCK):
                                value[i] = 0.0
                            for m in range(count):
                                cm, power = c[m], powers[m]
                                for i in range(BLOCK):
                                    value[i] += cm * power[i]
                            field = point[slab // (p + 1)]
                            for i in range(BLOCK):
                                field[i] = field[i] * t0[i] + value[i]
                        for i in range(BLOCK):
                            share = 1.0 / point[0, i]
                            s[0, i] *= share
                            s[1, i] *= share
                            s[2, i] *= share
                            turn = s[0, i] * point[1, i] + s[1, i] * point[2, i]
                            s[3, i] = (turn + s[2, i] * point[3, i]) * share
                    s0, s1, s2, s3 = s[0], s[1], s[2], s[3]
                    for at in range(p + 1):
                        if at > 0:
                            for i in range(BLOCK):
                                s0[i] *= t0[i]
                                s1[i] *= t0[i]
                                s2[i] *= t0[i]
                                if rational:
                                    s3[i] *= t0[i]
                        out = sums[cell, :, at]
                        for pair in range(wide // 2):
                            left, right = powers[2 * pair], powers[2 * pair + 1]
                            a0 = a1 = a2 = a3 = b0 = b1 = b2 = b3 = 0.0
                            for i in range(BLOCK):
                                a0 += s0[i] * left[i]
                                a1 += s1[i] * left[i]
                                a2 += s2[i] * left[i]
                                b0 += s0[i] * right[i]
                                b1 += s1[i] * right[i]
                                b2 += s2[i] * right[i]
                                if rational:
                                    a3 += s3[i] * left[i]
                                    b3 += s3[i] * right[i]
                            out[0, 2 * pair] += a0
                            out[1, 2 * pair] += a1
                            out[2, 2 * pair] += a2
                            out[0, 2 * pair + 1] += b0
                            out[1, 2 * pair + 1] += b1
                            out[2, 2 * pair + 1] += b2
                            if rational:
                                out[3, 2 * pair] += a3
                                out[3, 2 * pair + 1] += b3

    return compiled(moments, fastmath={"reassoc", "contract", "nsz"})
