"""Keeps the section through volume meshes in step: cut by workers, after each edit anew."""

from __future__ import annotations

import numpy as np
from psygnal import Signal
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QLabel, QSlider, QToolBar
from vtkmodules.vtkCommonDataModel import vtkPlane

from ffdstudio.gui.actors.section import Cut, cut, show
from ffdstudio.gui.actors.surface import SurfaceActor
from ffdstudio.gui.jobs import Progress
from ffdstudio.gui.listening import Listening
from ffdstudio.gui.navigation import Array
from ffdstudio.gui.scene import Scene
from ffdstudio.gui.state import Section
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.theme import Theme
from ffdstudio.project.model import Body
from ffdstudio.project.volume import countable

STEPS = 200


class Sections:
    """One cut a body; what lies between the plane and the viewer is hidden.

    `shown(key)` is emitted when the cut of a body is in the picture.
    """

    shown = Signal(str)

    def __init__(self, studio: Studio, scene: Scene) -> None:
        self._studio, self._scene = studio, scene
        self.actors: dict[str, SurfaceActor] = {}
        self.cuts: dict[str, Cut] = {}
        document = studio.document
        self._listening = Listening(
            (studio.state.shown_changed, self.update),
            (document.volume_changed, self._on_volume),
            (document.structure_changed, self.update),
        )

    def close(self) -> None:
        """Stop listening and leave the picture."""
        self._listening.stop()
        self._clear()

    def paint_with(self, _theme: Theme) -> None:
        """Take the colours of a theme."""
        self.update()

    def _on_volume(self, key: str) -> None:
        if self._studio.document.volume(key) is not None:
            self.update()

    def update(self) -> None:
        """Cut anew, or show all."""
        section, document = self._studio.state.shown.section, self._studio.document
        bodies = {body.key: body for body in document.model.bodies}
        if section is None:
            self._clear()
        for key, actor in self._scene.bodies.items():
            if section is None or key not in bodies or not _solid(bodies[key]):
                actor.clip(None)
                continue
            origin, normal = self._plane(bodies[key], section)
            actor.clip(self._clipping(origin, normal))
            self._start(bodies[key], origin, normal)
        self._scene.viewport.update()

    def _clear(self) -> None:
        for actor in self.actors.values():
            actor.close()
        self.actors.clear()

    def _plane(self, body: Body, section: Section) -> tuple[Array, Array]:
        low, high = body.mesh.bounds
        # not quite at the ends, where there is nothing to cut
        origin = low + (high - low) * (0.002 + 0.996 * section.place)
        return origin, np.eye(3)[section.axis]

    def _clipping(self, origin: Array, normal: Array) -> vtkPlane:
        """Plane that keeps what lies behind it, seen from where the viewer is."""
        viewport = self._scene.viewport
        towards = 1.0 if normal @ viewport.view.back >= 0 else -1.0
        plane = vtkPlane()
        plane.SetOrigin(*(origin - viewport.origin))
        plane.SetNormal(*(-towards * normal))
        return plane

    def _start(self, body: Body, origin: Array, normal: Array) -> None:
        volume = self._studio.document.volume(body.key)
        if volume is None:  # comes again when it is known
            return
        mesh, points = body.mesh, volume.points

        def work(progress: Progress) -> Cut:
            progress(0.0, "cutting")
            return cut(mesh, points, origin, normal)

        def done(found: Cut) -> None:
            self._show(body.key, found)

        self._studio.jobs.start(f"Cutting {body.name}", work, done, key=f"section {body.key}")

    def _show(self, key: str, found: Cut) -> None:
        old = self.actors.pop(key, None)
        if old is not None:
            old.close()
        if self._studio.state.shown.section is None or key not in self._scene.bodies:
            return
        viewport, theme = self._scene.viewport, self._studio.theme
        colours = theme.rgb("section"), theme.rgb("edge")
        self.cuts[key] = found
        self.actors[key] = show(viewport.renderer, found, viewport.origin, *colours)
        self.actors[key].show(self._studio.document.model.body(key).visible)
        viewport.update()
        self.shown.emit(key)


def _solid(body: Body) -> bool:
    return body.mesh.dimension == 3 and countable(body.mesh)


class SectionBar(QToolBar):
    """Axis and place of the section; shown while there is one."""

    def __init__(self, studio: Studio) -> None:
        super().__init__("Section")
        self.setObjectName("section")
        self._studio = studio
        self.axis, self.place = QComboBox(), QSlider(Qt.Orientation.Horizontal)
        self.axis.addItems(["across X", "across Y", "across Z"])
        self.axis.setAccessibleName("Axis of the section")
        self.place.setAccessibleName("Place of the section")
        self.place.setRange(0, STEPS)
        self.place.setFixedWidth(180)
        for widget in (QLabel(" Section "), self.axis, self.place):
            self.addWidget(widget)
        self.axis.activated.connect(self._tell)
        self.place.valueChanged.connect(self._tell)
        self._listening = Listening((studio.state.shown_changed, self.fill))
        self.fill()

    def close_panel(self) -> None:
        """Stop listening."""
        self._listening.stop()

    def paint_with(self, _theme: Theme) -> None:
        """Nothing here has a colour of its own."""

    def fill(self) -> None:
        """Show the section that there is."""
        section = self._studio.state.shown.section
        self.setVisible(section is not None)
        if section is not None:
            self.place.blockSignals(True)
            self.axis.setCurrentIndex(section.axis)
            self.place.setValue(round(STEPS * section.place))
            self.place.blockSignals(False)

    def _tell(self) -> None:
        section = Section(self.axis.currentIndex(), self.place.value() / STEPS)
        if self._studio.state.shown.section is not None:
            self._studio.state.show(section=section)
