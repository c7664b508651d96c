"""The advice of the form for a lattice: freeze where mesh lies on both sides of a face."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel, QSpinBox

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.gui.panels.fields import say
from ffdstudio.gui.studio import Studio
from ffdstudio.meshes import Mesh
from ffdstudio.project.checks.freezing import Face, advice, suggested
from ffdstudio.project.view.volume import DeformedVolume


class FreezeHint(QLabel):
    """Sets the number of frozen layers until the user does, and says why."""

    def __init__(self, studio: Studio, layers: QSpinBox) -> None:
        super().__init__()
        self._studio, self._layers = studio, layers
        self._advising = True
        self.setWordWrap(True)
        layers.valueChanged.connect(self._on_value)
        self._setting = False

    def begin(self, advising: bool = True) -> None:
        """Start with a new form; `advising` is whether to set the number."""
        self._advising = advising
        say(self, "")

    def look(self, lattice: Lattice | None, open_faces: tuple[Face, ...] = ()) -> bool:
        """Judge a lattice that is being built; whether the number of layers was changed."""
        if lattice is None:
            say(self, "")
            return False
        layers, faces = suggested(lattice, self._meshes(), open_faces)
        if self._advising and layers != self._layers.value():
            self._setting = True
            self._layers.setValue(layers)
            self._setting = False
            return True
        say(self, advice(lattice.shape, faces, self._layers.value(), open_faces))
        self.setProperty("role", "muted" if self._layers.value() else "warning")
        self.style().unpolish(self)
        self.style().polish(self)
        return False

    def _meshes(self) -> list[tuple[Mesh, Array]]:
        document = self._studio.document
        volumes = [(body.mesh, document.volume(body.key)) for body in document.model.bodies]
        return [(mesh, _points(mesh.points, volume)) for mesh, volume in volumes]

    def _on_value(self) -> None:
        if not self._setting:
            self._advising = False


def _points(rest: Array, volume: DeformedVolume | None) -> Array:
    return rest if volume is None else volume.points
