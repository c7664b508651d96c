"""The quality of the bodies, measured anew after each edit, and what is shown of it.

1. Reports follow *volume_changed*: the nodes are known then. Nothing is measured while nobody
   looks (`watch`), and the last report stays until the next one is there.
2. All that takes as long as there are cells (`digest`) is work for a worker, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from psygnal import Signal

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.measures import LIMITS, MEASURES, Limit
from ffdstudio.project.running import Progress
from ffdstudio.project.view.cellmap import cells_of
from ffdstudio.project.view.scales import Scale

if TYPE_CHECKING:
    from ffdstudio.meshes.measures.report import Report, Statistics, Worst
    from ffdstudio.meshes.measures.topology_checks import Connections
    from ffdstudio.project.document import Document

BINS = 40
WORST = 20
BOUNDED = ("skewness", "scaled_jacobian", "orthogonal_quality")  # to 1: no powers of ten


@dataclass(frozen=True, eq=False)
class Checked:
    """A mesh, its report, the cell of each displayed polygon, and how the cells hang together."""

    mesh: Mesh
    report: Report
    cells: Indices
    topology: Connections


@dataclass(frozen=True, eq=False)
class Digest:
    """What is shown of one measure of a body.

    Attributes
    ----------
    measure : str
    scale : Scale
        From least to largest value, before and now.
    edges, now, before : numpy.ndarray
        (bins + 1,) limits of the bins in the unit of the measure, (bins,) cells in each now and
        undeformed.
    statistics : Statistics
    worst : list of Worst
        The worst cells, the worst first.
    change : numpy.ndarray
        (cells,) now less undeformed; of a ratio to the undeformed mesh the ratio less 1.
    """

    measure: str
    scale: Scale
    edges: Array
    now: Indices
    before: Indices
    statistics: Statistics
    worst: list[Worst]
    change: Array


def digest(report: Report, measure: str) -> Digest:
    """Work out what is shown of a measure."""
    values = report.measures[measure]
    before = report.undeformed.get(measure, np.ones_like(values))
    scale = Scale.of(values, before)
    if measure in BOUNDED:
        scale = replace(scale, log=False)
    edges = scale.edges(BINS)
    return Digest(
        measure,
        scale,
        edges,
        _counted(values, edges),
        _counted(before if measure in report.undeformed else before[:0], edges),
        report.statistics(measure),
        report.worst(measure, WORST),
        values - before,
    )


def _counted(values: Array, edges: Array) -> Indices:
    finite = values[np.isfinite(values)]
    return np.asarray(np.histogram(np.clip(finite, edges[0], edges[-1]), edges)[0])


def beyond(values: Array, limit: Limit) -> int:
    """Count the cells beyond a limit.

    Examples
    --------
    >>> beyond(np.array([0.5, 0.95, np.nan]), Limit("Fluent", "skewness", ">", 0.9))
    1
    """
    over = values > limit.value if limit.relation == ">" else values < limit.value
    return int(over.sum())


def against(report: Report, preset: str) -> list[tuple[Limit, int, int]]:
    """Limits of a preset with the cells beyond them, undeformed and now."""
    return [
        (limit, beyond(report.undeformed[limit.measure], limit), count)
        for limit, count in report.limits.items()
        if limit.preset == preset
    ]


def presets() -> list[str]:
    """Names of the solvers whose limits are known."""
    return list(dict.fromkeys(limit.preset for limit in LIMITS))


class Checks:
    """Reports of the bodies of a document.

    Attributes
    ----------
    trouble : dict of str to str
        Why a body has no report, by its key.

    Notes
    -----
    Signals: ``changed(key)`` when there is a new report or none any more; ``digested(key)`` when
    the `digest` that was asked for is there.
    """

    changed = Signal(str)
    digested = Signal(str)

    def __init__(self, document: Document) -> None:
        self._document = document
        self._watching = False
        self._known: dict[str, Checked] = {}
        self._points: dict[str, object] = {}
        self._digests: dict[tuple[str, str], Digest] = {}
        self.trouble: dict[str, str] = {}
        document.volume_changed.connect(self._on_volume)
        document.structure_changed.connect(self._on_structure)

    def close(self) -> None:
        """Stop listening."""
        self._document.volume_changed.disconnect(self._on_volume)
        self._document.structure_changed.disconnect(self._on_structure)

    def watch(self, on: bool) -> None:
        """Begin or stop to measure after each edit."""
        self._watching = on
        if on:
            for body in self._document.model.bodies:
                self._on_volume(body.key)

    def report(self, key: str) -> Report | None:
        """Latest report of a body; None if there is none, or no such body any more."""
        found = self._checked(key)
        return None if found is None else found.report

    def topology(self, key: str) -> Connections | None:
        """How the cells of a body hang together; None until its report is there."""
        found = self._checked(key)
        return None if found is None else found.topology

    def cells(self, key: str) -> Indices | None:
        """Cell of each displayed polygon of a body."""
        found = self._checked(key)
        return None if found is None else found.cells

    def current(self, key: str) -> bool:
        """Whether the latest report is about the shape as it is."""
        volume = None if self._checked(key) is None else self._document.volume(key)
        return volume is not None and self._points.get(key) is volume.points

    def _checked(self, key: str) -> Checked | None:
        """What is known of a body of the model: views may ask before this has heard it go."""
        found = self._known.get(key)
        return found if found is not None and self._mesh(key) is found.mesh else None

    def _mesh(self, key: str) -> Mesh | None:
        return next((b.mesh for b in self._document.model.bodies if b.key == key), None)

    def digest(self, key: str, measure: str) -> Digest | None:
        """What is shown of a measure; if it is None, `digested` tells when it is there."""
        known = self._digests.get((key, measure))
        report = self.report(key)
        if known is not None or report is None or measure not in report.measures:
            return known

        def done(made: Digest) -> None:
            if self.report(key) is report:
                self._digests[key, measure] = made
                self.digested.emit(key)

        def work(_progress: Progress) -> Digest:
            return digest(report, measure)

        label = f"Counting {MEASURES[measure].title}"
        self._document.runner.start(label, work, done, key=f"digest {key} {measure}")
        return self._digests.get((key, measure))

    # ---- keeping up -----------------------------------------------------------------------

    def _on_structure(self) -> None:
        """Let go of all that is gone before anybody is told: who is told asks for the others."""
        meshes = {body.key: body.mesh for body in self._document.model.bodies}
        gone = {k for k, known in self._known.items() if meshes.get(k) is not known.mesh}
        gone |= (self._points.keys() | self.trouble.keys()) - meshes.keys()
        for key in sorted(gone):
            self._drop(key)
        for key in sorted(gone):
            self.changed.emit(key)

    def _drop(self, key: str) -> None:
        self._known.pop(key, None)
        self._points.pop(key, None)
        self.trouble.pop(key, None)
        self._digests = {pair: made for pair, made in self._digests.items() if pair[0] != key}

    def _on_volume(self, key: str) -> None:
        volume = self._document.volume(key)
        if not self._watching or volume is None or self._points.get(key) is volume.points:
            return
        document, points = self._document, volume.points
        body, surface = document.model.body(key), document.surface(key)
        known = self._known.get(key)  # the polygons belong to the same cells for ever
        self._points[key] = points

        def work(progress: Progress) -> Checked:
            from ffdstudio.meshes.measures import quality
            from ffdstudio.meshes.measures.topology_checks import connections

            progress(0.0, "measuring the cells")
            report = quality(body.mesh, points)
            _ = report.limits, report.solver_tests
            cells = known.cells if known else cells_of(body.mesh, surface)
            return Checked(body.mesh, report, cells, connections(body.mesh))

        def done(checked: Checked) -> None:
            if self._points.get(key) is points and self._mesh(key) is body.mesh:
                self._drop(key)
                self._known[key], self._points[key] = checked, points
                self.changed.emit(key)

        def failed(error: Exception) -> None:
            if not isinstance(error, InputError):
                raise error
            if self._mesh(key) is not body.mesh:
                return
            self._drop(key)
            self._points[key], self.trouble[key] = points, str(error)
            self.changed.emit(key)

        def cancelled() -> None:
            if self._points.get(key) is points:
                del self._points[key]
                self.trouble[key] = "measuring was cancelled"
                self.changed.emit(key)

        label = f"Measuring {body.name}"
        document.runner.start(label, work, done, failed, f"quality {key}", cancelled=cancelled)
