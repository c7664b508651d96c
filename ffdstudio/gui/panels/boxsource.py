"""What a lattice can be laid around: everything, a body, a marker, or bounds that are typed."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import QComboBox

from ffdstudio.aliases import Array
from ffdstudio.meshes.planes import planes_of
from ffdstudio.meshes.quasi2d import is_plane
from ffdstudio.meshes.walls import wall_markers
from ffdstudio.project.document import Document
from ffdstudio.project.placing.placement import Site
from ffdstudio.project.plane_constraints import planes_in

TYPED = "typed bounds"


class BoxSource:
    """The choice of what to lay a lattice around, in a combo box."""

    def __init__(self, document: Document, box: QComboBox) -> None:
        self._document, self.box = document, box

    @property
    def typed(self) -> bool:
        """Whether bounds are typed, around nothing in particular."""
        return bool(self.box.currentData() == TYPED)

    @property
    def flat(self) -> bool:
        """Whether all there is, is plane or stands for a plane mesh."""
        bodies = self._document.model.bodies
        return bool(bodies) and all(is_plane(body.mesh) for body in bodies)

    def offer(self, source: object) -> None:
        """List all there is to lay a lattice around; choose a source, or everything."""
        self.box.clear()
        self.box.addItem("Everything", ("", ""))
        for body in self._document.model.bodies:
            self.box.addItem(body.name, (body.key, ""))
            for name in self._document.surface(body.key).markers:
                self.box.addItem(f"{body.name}: {name}", (body.key, name))
        self.box.addItem("Typed bounds", TYPED)
        self.choose(source)

    def choose(self, source: object) -> None:
        """Choose a source, if it is offered."""
        for number in range(self.box.count()):
            if self.box.itemData(number) == source:
                self.box.setCurrentIndex(number)

    def wall(self) -> tuple[str, str]:
        """Key and marker of the wall in a mesh with a far field; nothing if there is none."""
        for body in self._document.model.bodies:
            names = wall_markers(body.mesh)
            if len(names) == 1:
                return body.key, names[0]
        return "", ""

    def plane_axes(self) -> Array | None:
        """(2, 3) right and up of the plane that all meshes stand for; None for x and y."""
        meshes = [(body.mesh, body.mesh.points) for body in self._document.model.bodies]
        return Site(np.zeros((0, 3)), tuple(meshes)).axes

    def site(self) -> Site:
        """What the lattice is to move, as it is now, and the meshes around."""
        document, source = self._document, self.box.currentData()
        bodies = document.model.bodies
        key, marker = ("", "") if source == TYPED else source
        meshes = []
        for body in bodies:
            volume = document.volume(body.key)
            meshes.append((body.mesh, body.mesh.points if volume is None else volume.points))
        if not key:
            clouds = [document.points(body.key) for body in bodies]
            skin = np.concatenate(clouds) if clouds else np.zeros((0, 3))
            return Site(skin, tuple(meshes), planes_in(document.model))
        skin = document.points(key)
        if marker:
            skin = skin[document.surface(key).marker_points(marker)]
        return Site(skin, tuple(meshes), planes_of(document.model.body(key).mesh))
