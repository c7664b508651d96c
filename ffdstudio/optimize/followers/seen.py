"""What a cost and constraints see of points behind which those of the air are listed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.optimize.constraints.base import Quantity, Values, measured
from ffdstudio.optimize.objectives.base import Evaluation, Objective, Request, Response, Start
from ffdstudio.optimize.objectives.stream import then


class SeenObjective(Objective):
    """An objective of the first `count` of `total` points; the others move no cost."""

    def __init__(self, inner: Objective, count: int, total: int) -> None:
        self.inner, self.count, self.total = inner, count, total
        self.abilities = inner.abilities

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        return self._padded(self.inner.answer(self._cut(request)))

    @contextmanager
    def starting(self) -> Iterator[Start]:
        """See `Objective`."""
        with self.inner.starting() as start:

            def begin(request: Request) -> Future[Evaluation]:
                return then(start(self._cut(request)), self._padded)

            yield begin

    def pressures(self, points: Array) -> Mapping[str, Mapping[str, tuple[Array, Array]]]:
        """See `Objective`."""
        return self.inner.pressures(points[: self.count])

    def response(self, points: Array) -> Response | None:
        """See `Objective`."""
        return padded(self.inner.response(points[: self.count]), self.total)

    def _cut(self, request: Request) -> Request:
        return request._replace(points=request.points[: self.count])

    def _padded(self, found: Evaluation) -> Evaluation:
        gradient, rows = found.gradient, found.sensitivity
        if gradient is not None:
            gradient = np.vstack([gradient, np.zeros((self.total - self.count, 3))])
        if rows is not None:
            rows = rows.tocsc(copy=True)
            rows.resize(rows.shape[0], 3 * self.total)
            rows = rows.tocsr()
        return replace(found, gradient=gradient, sensitivity=rows)


def padded(found: Response | None, total: int) -> Response | None:
    """A response of the first points, with columns for those behind."""
    from scipy.sparse import csr_array

    if found is None:
        return None
    matrix: Any = csr_array(found.matrix)
    matrix.resize(matrix.shape[0], 3 * total)
    return found._replace(matrix=matrix)


class SeenQuantity(Quantity):
    """A quantity of the first `count` points."""

    def __init__(self, inner: Quantity, count: int) -> None:
        self.inner, self.count, self.angles = inner, count, inner.angles

    def __call__(self, points: Array) -> Values:
        """See `Quantity`."""
        values, rows = self.inner(points[: self.count])
        part = rows.toarray() if hasattr(rows, "toarray") else np.asarray(rows)
        rest = np.zeros((len(values), 3 * (len(points) - self.count)))
        return Values(values, np.hstack([part.reshape(len(values), -1), rest]))

    def values(self, points: Array) -> Array:
        """See `Quantity`."""
        return measured(self.inner, points[: self.count], derivatives=False).values
