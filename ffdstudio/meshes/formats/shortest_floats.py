"""Shortest decimals of many doubles at once, the same text as Python's ``repr``.

Saving a morphed mesh is mostly this, and ``repr`` takes 0.4 us a number. Here, for numbers in
[1e-4, 1e16) that ``repr`` writes without an exponent:

1. The number times 10**k, k <= 20, shall have 17 digits before the point. 10**k is a double, so
   the product of both is exactly a sum of two doubles (Dekker's product), the first an integer.
2. Half the distance to the next doubles, scaled likewise, is exact, too. The nearest multiple
   of 100 (15 digits) or of 10 (16 digits) reads back as the same number if it is closer than
   that; 17 digits always do. There is at most one multiple of 100 so close, so trailing zeros
   of 15 digits may be dropped.
3. Whatever is not clear beyond rounding (a tie, a power of two, another size) goes to ``repr``.

T. J. Dekker, "A floating-point technique for extending the available precision", 1971.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, Indices

SPLIT = 134217729.0  # 2**27 + 1
POWERS: Array = 10.0 ** np.arange(22, dtype=np.float64)
LOWEST, HIGHEST = 1e-4, 1e16
POINT, ZERO, MINUS, NEWLINE = b".0-\n"


def shortest_texts(values: Array) -> list[bytes]:
    """Texts that read back as the same doubles, none of them longer than need be.

    Parameters
    ----------
    values : numpy.ndarray
        (n,) finite numbers.

    Examples
    --------
    >>> shortest_texts(np.array([0.1, -1 / 3, 1e22, 0.0, 12.0]))
    [b'0.1', b'-0.3333333333333333', b'1e+22', b'0.0', b'12.0']
    """
    size = np.abs(values)
    plain = (size >= LOWEST) & (size < HIGHEST) & (np.frexp(size)[0] != 0.5)
    digits, exponent, clear = _digits(np.where(plain, size, 1.5))
    plain &= clear
    texts = np.empty(len(values), dtype=object)
    for power in np.unique(exponent[plain]).tolist():
        rows = np.flatnonzero(plain & (exponent == power))
        texts[rows] = _laid_out(digits[rows], power, values[rows] < 0)
    texts[~plain] = [repr(value).encode() for value in values[~plain].tolist()]
    found: list[bytes] = texts.tolist()
    return found


def _digits(size: Array) -> tuple[Indices, Indices, NDArray[np.bool_]]:
    """17 digits as an integer with zeros behind the shortest ones, exponent of ten, certainty."""
    exponent = np.floor(np.log10(size)).astype(np.int64)
    high, low = _product(size, POWERS[16 - exponent])
    exponent += np.where(high >= 1e17, 1, np.where(high < 1e16, -1, 0))
    power = POWERS[np.clip(16 - exponent, 0, 21)]
    high, low = _product(size, power)
    half = 0.5 * np.spacing(size) * power
    whole = high.astype(np.int64)
    found = whole + np.rint(low).astype(np.int64)
    clear = (np.abs(low - np.rint(low)) < 0.49) & (high >= 1e16) & (high < 1e17)
    for step in (10, 100):
        rest = (whole % step) + low
        near = np.rint(rest / step)
        gap = np.abs(rest - near * step)
        fits = gap < half
        clear &= ~(np.abs(gap - half) < 1e-6) & ~(np.abs(gap - step / 2) < 1e-6) | (gap > 2 * half)
        found = np.where(fits, whole - whole % step + near.astype(np.int64) * step, found)
    over = found >= 10**17
    return np.where(over, found // 10, found), exponent + over, clear


def _product(a: Array, b: Array) -> tuple[Array, Array]:
    """Product as a rounded value and the exact rest."""
    whole = a * b
    (a_high, a_low), (b_high, b_low) = _halves(a), _halves(b)
    rest = ((a_high * b_high - whole) + a_high * b_low + a_low * b_high) + a_low * b_low
    return whole, rest


def _halves(a: Array) -> tuple[Array, Array]:
    high = SPLIT * a
    high = high - (high - a)
    return high, a - high


def _laid_out(digits: Indices, power: int, negative: NDArray[np.bool_]) -> list[bytes]:
    """Texts of numbers of one exponent of ten, from their 17 digits."""
    upper, lower = (digits // 10**8).astype(np.uint32), (digits % 10**8).astype(np.uint32)
    columns = [upper // np.uint32(10**k) % np.uint32(10) for k in range(8, -1, -1)]
    columns += [lower // np.uint32(10**k) % np.uint32(10) for k in range(7, -1, -1)]
    table = np.stack(columns, axis=1).astype(np.uint8)
    used = 17 - np.argmax(table[:, ::-1] != 0, axis=1)  # digits up to the last that is not zero
    zeros = max(-power - 1, 0)
    before = max(power + 1, 0)
    lead = [ZERO] * (power < 0)
    text = np.full((len(digits), 1 + len(lead) + 1 + zeros + 17 + 1), ZERO, dtype=np.uint8)
    keep = np.ones(text.shape, dtype=bool)
    text[:, 0], keep[:, 0] = MINUS, negative
    at = 1 + len(lead)
    text[:, at : at + before] = table[:, :before] + ZERO
    text[:, at + before] = POINT
    rest = text[:, at + before + 1 + zeros : -1]
    rest[:] = table[:, before:] + ZERO
    shown = np.maximum(used, before + 1)  # at least one digit behind the point
    keep[:, at + before + 1 + zeros : -1] = np.arange(before, 17) < shown[:, None]
    text[:, -1] = NEWLINE
    return text[keep].tobytes().split(b"\n")[:-1]
