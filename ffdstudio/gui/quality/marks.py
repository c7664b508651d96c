"""The picked worst cell, drawn over everything: it usually lies inside the mesh."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.gui.overlay import Line, Ring, Shape, Text
from ffdstudio.gui.quality.choice import Choice
from ffdstudio.gui.quality.flying import Flight
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.viewport import Viewport
from ffdstudio.meshes.measures.blocks import blocks_of
from ffdstudio.meshes.measures.faces import Topology, topology_of
from ffdstudio.project.checks.checking import Checks
from ffdstudio.project.document import Document

ROOM = 6.0  # sizes of a cell that are shown around it
SMALL = 8.0  # pixels: a smaller cell gets a ring


class CellMark:
    """Edges of the picked cell in the overlay; flies there when another one is picked."""

    def __init__(
        self, viewport: Viewport, document: Document, checks: Checks, choice: Choice
    ) -> None:
        self._viewport, self._document = viewport, document
        self._checks, self._choice = checks, choice
        self.flight = Flight(viewport)
        self._picked = -1
        self._listening = Listening(
            (choice.changed, self._on_choice), (checks.changed, self._on_report)
        )
        viewport.painted.connect(self._draw)

    def close(self) -> None:
        """Stop listening."""
        self.flight.close()
        self._listening.stop()
        self._viewport.painted.disconnect(self._draw)

    def edges(self) -> Array:
        """(k, 2, 3) edges of the picked cell."""
        wanted, report = self._choice.wanted, self._checks.report(self._choice.wanted.body)
        if report is None or not 0 <= wanted.cell < report.cells:
            return np.zeros((0, 2, 3))
        mesh = self._document.model.body(wanted.body).mesh
        if blocks_of(mesh).dimension == 3:
            return report.points[edges_of(topology_of(mesh), wanted.cell)]
        surface = self._document.surface(wanted.body)  # its polygons are the cells
        begin, end = surface.offsets[wanted.cell : wanted.cell + 2]
        loop = surface.nodes[surface.connectivity[begin:end]]
        return report.points[np.stack([loop, np.roll(loop, -1)], axis=1)]

    def _on_report(self, _key: str) -> None:
        self._viewport.update()

    def _on_choice(self) -> None:
        cell, edges = self._choice.wanted.cell, self.edges()
        if cell != self._picked and len(edges):
            points = edges.reshape(-1, 3)
            low, high = points.min(axis=0), points.max(axis=0)
            room = ROOM * float((high - low).max())
            self.flight.to(np.array([low - room, high + room]))
        self._picked = cell
        self._viewport.update()

    def _draw(self) -> None:
        self._viewport.overlay.put("worst", self._shapes())

    def _shapes(self) -> Iterator[Shape]:
        edges = self.edges()
        if not len(edges):
            return
        pixels = self._viewport.camera_now().project(edges.reshape(-1, 3))
        if not np.isfinite(pixels).all():
            return
        for start, end in pixels.reshape(-1, 2, 2).tolist():
            yield Line((start[0], start[1]), (end[0], end[1]), "danger", 2.0)
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        if float((high - low).max()) < SMALL:
            yield Ring(tuple((low + high) / 2), 9.0, "danger", 2.0)
        name = f"cell {self._choice.wanted.cell}"
        yield Text((high[0] + 8, low[1] - 6), (name,), "danger", plate=True)


def edges_of(topology: Topology, cell: int) -> NDArray[np.int64]:
    """(k, 2) nodes of the edges of a volume cell."""
    faces, begin = topology.faces, topology.cell_offsets
    pairs = []
    for face in topology.cell_faces[begin[cell] : begin[cell + 1]]:
        loop = faces.nodes[faces.offsets[face] : faces.offsets[face + 1]]
        pairs.append(np.stack([loop, np.roll(loop, -1)], axis=1))
    return np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
