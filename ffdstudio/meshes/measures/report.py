"""The report of the quality of a mesh: measures per cell and what is to be said of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.meshes.measures.cell_coverage import Coverage
from ffdstudio.meshes.measures.incremental import QualityState
from ffdstudio.meshes.measures.solvers import dual_volumes, wrong_pyramids
from ffdstudio.meshes.measures.standards import LIMITS, MEASURES, Limit

PERCENTILES = (1, 5, 50, 95, 99)


@dataclass(frozen=True)
class Statistics:
    """Least, largest and mean value, and percentiles 1, 5, 50, 95, 99, of finite values."""

    min: float
    max: float
    mean: float
    percentiles: dict[int, float]


@dataclass(frozen=True)
class Worst:
    """A cell, its value of a measure, and the mean of its nodes."""

    cell: int
    value: float
    place: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Report:
    """Quality of a mesh at given points, against the undeformed mesh.

    Attributes
    ----------
    measures : dict
        Name -> (cells,) values; NaN where a cell has none. Names as in `MEASURES`; a surface
        in space has no measures of faces, a mesh without wall markers no first layer.
    undeformed : dict
        The same of the undeformed mesh, without the ratios.
    inverted : numpy.ndarray
        (cells,) mask, as `ffdstudio.meshes.inverted` has it.
    points : numpy.ndarray
        The (n, 3) points reported on.
    coverage : Coverage
        Which cells of the mesh this is about, and which were not checked.
    """

    measures: dict[str, Array]
    undeformed: dict[str, Array]
    inverted: np.ndarray
    points: Array
    state: QualityState = field(repr=False)
    coverage: Coverage = field(default_factory=Coverage)

    @property
    def cells(self) -> int:
        """Number of cells of the highest dimension."""
        return len(self.inverted)

    @property
    def negative(self) -> int:
        """Number of cells with a corner against the order that most cells of their type have.

        They are bad whether or not they were so in the undeformed mesh.
        """
        return int((self.measures["scaled_jacobian"] < 0).sum())

    def statistics(self, measure: str) -> Statistics:
        """Statistics of one measure; NaN if no cell has it."""
        return statistics(self.measures[measure])

    def badness(self, measure: str) -> Array:
        """(cells,) value that grows as a cell gets worse; -inf for cells without the measure."""
        values = self.measures[measure]
        with np.errstate(divide="ignore", invalid="ignore"):
            match MEASURES[measure].worst:
                case "high":
                    bad = values
                case "low":
                    bad = -values
                case _:
                    bad = np.where(values > 0, np.abs(np.log(values)), np.inf)
        return np.where(np.isnan(values), -np.inf, bad)

    def worst(self, measure: str, count: int = 5) -> list[Worst]:
        """Cells with the worst values, the worst first."""
        bad = self.badness(measure)
        count = min(count, int((bad > -np.inf).sum()))
        if count == 0:
            return []
        cells = np.argpartition(-bad, count - 1)[:count]
        cells = cells[np.argsort(-bad[cells], kind="stable")]
        places = self.state.places(self.points, cells).tolist()
        values = self.measures[measure][cells].tolist()
        return [
            Worst(int(cell), value, (x, y, z))
            for cell, value, (x, y, z) in zip(cells, values, places, strict=True)
        ]

    def beyond(self, limit: Limit) -> Indices:
        """Cells beyond a limit."""
        values = self.measures[limit.measure]
        over = values > limit.value if limit.relation == ">" else values < limit.value
        return np.flatnonzero(over)

    @cached_property
    def limits(self) -> dict[Limit, int]:
        """Number of cells beyond each limit of the solvers' presets that applies."""
        solvable = self.state.fabric is not None  # a surface has no volume to be negative
        return {
            limit: len(self.beyond(limit))
            for limit in LIMITS
            if limit.measure in self.measures and (solvable or limit.measure != "volume")
        }

    @cached_property
    def solver_tests(self) -> dict[str, int]:
        """Failures of OpenFOAM's and SU2's own tests: faces, cells and nodes; none of surfaces."""
        fabric = self.state.fabric
        if fabric is None:
            return {}
        with self.state.lock:
            self.state.move(self.points)
            pyramids = wrong_pyramids(fabric)
        dual = dual_volumes(self.state.blocks, self.points, self.state.undeformed)
        return {
            "OpenFOAM wrong face pyramids": pyramids,
            "OpenFOAM negative volumes": int((self.measures["volume"] < 0).sum()),
            "SU2 negative dual volumes": int((dual <= 0).sum()),
        }

    def to_dict(self, worst: int = 5) -> dict[str, Any]:
        """Return the report as what JSON knows; None for values that are not finite."""
        return {
            "cells": self.cells,
            "inverted": int(self.inverted.sum()),
            "negative": self.negative,
            "unchecked": self.coverage.missing,
            "unchecked_types": self.coverage.unchecked,
            "inverted_cells": np.flatnonzero(self.inverted)[:100].tolist(),
            "measures": {name: self._entry(name, worst) for name in self.measures},
            "beyond": [
                {
                    "preset": limit.preset,
                    "measure": limit.measure,
                    "limit": f"{limit.relation} {limit.value:g}",
                    "cells": count,
                }
                for limit, count in self.limits.items()
            ],
            "solver_tests": self.solver_tests,
        }

    def _entry(self, name: str, worst: int) -> dict[str, Any]:
        numbers = self.statistics(name)
        return {
            "min": _finite(numbers.min),
            "max": _finite(numbers.max),
            "mean": _finite(numbers.mean),
            "percentiles": {str(k): _finite(v) for k, v in numbers.percentiles.items()},
            "standard": MEASURES[name].standard,
            "worst": [
                {"cell": w.cell, "value": _finite(w.value), "place": list(w.place)}
                for w in self.worst(name, worst)
            ],
        }


def statistics(values: Array) -> Statistics:
    """Statistics of the finite ones of these values.

    Examples
    --------
    >>> statistics(np.array([1.0, 3.0, np.nan])).mean
    2.0
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return Statistics(np.nan, np.nan, np.nan, dict.fromkeys(PERCENTILES, np.nan))
    levels = np.percentile(finite, PERCENTILES).tolist()
    least, most, mean = float(finite.min()), float(finite.max()), float(finite.mean())
    return Statistics(least, most, mean, dict(zip(PERCENTILES, levels, strict=True)))


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
