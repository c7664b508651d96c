"""Objectives of sections wherever they lie and however long they are, told in chords."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace

from ffdstudio.aliases import Array
from ffdstudio.optimize.geometry.chord import Chord
from ffdstudio.optimize.objectives.base import Evaluation, Objective, Request, Response, Start
from ffdstudio.optimize.objectives.stream import then


class InChords(Objective):
    """An objective that is told in chords, seen from the mesh's units."""

    def __init__(self, inner: Objective, chord: Chord) -> None:
        self.inner, self.chord, self.abilities = inner, chord, inner.abilities

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        return self._in_units(self.inner.answer(self._local(request)))

    @contextmanager
    def starting(self) -> Iterator[Start]:
        """See `Objective`."""
        with self.inner.starting() as start:

            def begin(request: Request) -> Future[Evaluation]:
                return then(start(self._local(request)), self._in_units)

            yield begin

    def pressures(self, points: Array) -> Mapping[str, Mapping[str, tuple[Array, Array]]]:
        """See `Objective`."""
        return self.inner.pressures(self.chord.local(points))

    def response(self, points: Array) -> Response | None:
        """See `Objective`."""
        found = self.inner.response(self.chord.local(points))
        return None if found is None else found._replace(matrix=found.matrix / self.chord.length)

    def _local(self, request: Request) -> Request:
        return request._replace(points=self.chord.local(request.points))

    def _in_units(self, found: Evaluation) -> Evaluation:
        """Derivatives by coordinates, not by chords."""
        length, gradient, rows = self.chord.length, found.gradient, found.sensitivity
        return replace(
            found,
            gradient=None if gradient is None else gradient / length,
            sensitivity=None if rows is None else rows / length,
        )
