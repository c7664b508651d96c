"""A cost of all nodes of a mesh whose volume follows its walls."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace

from ffdstudio.aliases import Array
from ffdstudio.optimize.followers.body import FollowingMesh
from ffdstudio.optimize.objectives.base import Evaluation, Objective, Request, Start
from ffdstudio.optimize.objectives.stream import then


class ThroughWalls(Objective):
    """An objective of the nodes as they follow, seen from where the lattice takes them."""

    def __init__(self, inner: Objective, body: FollowingMesh) -> None:
        self.inner, self.body, self.abilities = inner, body, inner.abilities

    def answer(self, request: Request) -> Evaluation:
        """See `Objective`."""
        return self._pulled(self.inner.answer(self._followed(request)), request.points)

    @contextmanager
    def starting(self) -> Iterator[Start]:
        """See `Objective`."""
        with self.inner.starting() as start:

            def begin(request: Request) -> Future[Evaluation]:
                found = start(self._followed(request))
                return then(found, lambda answer: self._pulled(answer, request.points))

            yield begin

    def _followed(self, request: Request) -> Request:
        return request._replace(points=self.body.followed(request.points))

    def _pulled(self, found: Evaluation, carried: Array) -> Evaluation:
        if found.gradient is None:
            return found
        return replace(found, gradient=self.body.pull(found.gradient, carried))
