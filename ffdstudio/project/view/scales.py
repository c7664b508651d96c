"""From values of a measure to places on a scale, linear or by powers of ten."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array

WIDE = 500.0  # ratio of the largest to the median value from which powers of ten are used


@dataclass(frozen=True)
class Scale:
    """Scale from `low` to `high`; `log` where it goes by powers of ten."""

    low: float
    high: float
    log: bool = False

    @classmethod
    def of(cls, *arrays: Array) -> Scale:
        """Scale over all finite values.

        Examples
        --------
        >>> Scale.of(np.array([1.0, 2.0]), np.array([np.nan, 2000.0]))
        Scale(low=1.0, high=2000.0, log=True)
        """
        finite = np.concatenate([values[np.isfinite(values)] for values in arrays])
        if not len(finite):
            return cls(0.0, 1.0)
        low, high = float(finite.min()), float(finite.max())
        # not by the least value: one cell without any skewness is no reason
        return cls(low, high, low > 0 and high > WIDE * float(np.median(finite)))

    @classmethod
    def around(cls, values: Array, centre: float = 0.0) -> Scale:
        """Scale that reaches as far below the centre as above."""
        finite = np.abs(values[np.isfinite(values)] - centre)
        far = float(finite.max()) if len(finite) else 0.0
        return cls(centre - far, centre + far)

    def place(self, values: ArrayLike) -> Array:
        """Places in [0, 1]; NaN stays NaN. A scale without extent puts all in the middle.

        Examples
        --------
        >>> Scale(1, 100, log=True).place([1, 10, 1000])
        array([0. , 0.5, 1. ])
        """
        x, low, high = self._own(np.asarray(values, dtype=np.float64)), *self._ends
        if not high > low:
            return np.where(np.isnan(x), np.nan, 0.5)
        return np.clip((x - low) / (high - low), 0.0, 1.0)

    def value(self, place: float) -> float:
        """Value at a place in [0, 1]."""
        low, high = self._ends
        x = low + place * (high - low)
        return float(10.0**x if self.log else x)

    def edges(self, count: int) -> Array:
        """(count + 1,) limits of bins of equal width on the scale."""
        low, high = self._ends
        if not high - low > 1e-12 * max(abs(low), abs(high)):  # all alike: a bin for them
            room = max(abs(low), abs(high), 1e-300) * 1e-6
            return np.linspace(self.low - room, self.high + room, count + 1)
        x = np.linspace(low, high, count + 1)
        edges = 10.0**x if self.log else x
        edges[0], edges[-1] = self.low, self.high  # not a rounding error inside them
        return edges

    @property
    def _ends(self) -> tuple[float, float]:
        low, high = self._own(np.array([self.low, self.high])).tolist()
        return low, high

    def _own(self, values: Array) -> Array:
        if not self.log:
            return values
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.log10(np.maximum(values, 1e-300)))
