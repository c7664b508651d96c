"""The smallest positive root of many polynomials c0 + c1 t + c2 t^2 + c3 t^3 with c0 > 0.

1. They are solved in s = 1/t: s^3 + (c1 s^2 + c2 s + c3) / c0 has a leading coefficient of 1
   whatever the others are, so nothing is divided by a vanishing c3, and the smallest t is the
   largest s. Linear and quadratic polynomials are the same with roots at s = 0, that is never.
2. No root exceeds Fujiwara's bound 2 max(|c1/c0|, |c2/c0|^(1/2), |c3/2c0|^(1/3)); the two
   critical points cut the way down from there into monotone pieces, and the first piece with a
   change of sign is bisected.
3. Only the smallest t of all is wanted: a bracket below the best one so far is dropped.
4. A coefficient that consists of rounding has no sign, and the far root it seems to cause is
   none: it counts as zero. Whoever knows what was summed tells how large rounding may be.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array

STEPS = 80


def smallest(c0: Array, c1: Array, c2: Array, c3: Array, noise: Array | None = None) -> float:
    """Smallest positive root of all polynomials; infinity if none has one.

    Parameters
    ----------
    c0, c1, c2, c3 : numpy.ndarray
        (n,) coefficients; c0 is positive.
    noise : numpy.ndarray, optional
        (3, n) how large c1, c2 and c3 may be by rounding alone.

    Examples
    --------
    >>> one = np.ones(1)
    >>> round(smallest(one, -3 * one, 2 * one, 0 * one), 12)
    0.5
    >>> smallest(one, one, -1e-17 * one, 0 * one, 1e-15 * np.ones((3, 1)))
    inf
    """
    if noise is not None:
        rows = zip((c1, c2, c3), noise, strict=True)
        c1, c2, c3 = (np.where(np.abs(c) > least, c, 0.0) for c, least in rows)
    with np.errstate(over="ignore", invalid="ignore"):
        a, b, c = c1 / c0, c2 / c0, c3 / c0
        bound = 2 * np.maximum(np.maximum(np.abs(a), np.abs(b) ** 0.5), np.abs(c / 2) ** (1 / 3))
    some = np.flatnonzero((bound > 0) & np.isfinite(bound))
    a, b, c = a[some], b[some], c[some]
    low, high, found = _brackets(a, b, c, bound[some])
    a, b, c, low, high = (v[found] for v in (a, b, c, low, high))
    if not len(a):
        return np.inf
    for _ in range(STEPS):
        keep = high >= low.max()
        a, b, c, low, high = (v[keep] for v in (a, b, c, low, high))
        middle = (low + high) / 2
        below = _value(middle, a, b, c) <= 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return float(1 / low.max()) if low.max() > 0 else np.inf


def _value(s: Array, a: Array, b: Array, c: Array) -> Array:
    return ((s + a) * s + b) * s + c


def _brackets(a: Array, b: Array, c: Array, bound: Array) -> tuple[Array, Array, np.ndarray]:
    """Interval of the largest root in (0, bound], and where there is one."""
    spread = a * a - 3 * b
    root = np.sqrt(np.maximum(spread, 0))
    upper = np.clip((root - a) / 3, 0, bound)
    lower = np.clip((-root - a) / 3, 0, upper)
    zero = np.zeros_like(a)
    at = [_value(s, a, b, c) for s in (upper, lower)]
    first, second = at[0] <= 0, at[1] <= 0
    low = np.where(first, upper, np.where(second, lower, zero))
    high = np.where(first, bound, np.where(second, upper, lower))
    found = (first & (upper > 0)) | (second & (lower > 0)) | (c < 0)
    return low, high, found
