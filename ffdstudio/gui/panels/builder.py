"""The form that builds a lattice, with live preview in the picture."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.boxes import Frame
from ffdstudio.errors import InputError
from ffdstudio.gui.errors import sentence
from ffdstudio.gui.first_view import walls
from ffdstudio.gui.panels.boxform import BoxForm
from ffdstudio.gui.panels.draft import (
    Draft,
    angles_of,
    inside_box,
    principal_frame,
)
from ffdstudio.gui.panels.fields import say
from ffdstudio.gui.studio import Studio
from ffdstudio.meshes.planes import Plane, planes_of
from ffdstudio.project.checks.freezing import Face
from ffdstudio.project.checks.plane_snapping import seat_sentence, seated
from ffdstudio.project.commands import CreateBox, Refit
from ffdstudio.project.model import LatticeItem
from ffdstudio.project.plane_constraints import planes_in

TYPED = "typed bounds"


class Builder(BoxForm):
    """Fields of a `Draft`; every change shows the lattice or says what is wrong."""

    def __init__(self, studio: Studio, finished: Callable[[], None]) -> None:
        super().__init__(studio)
        self._studio, self._finished = studio, finished
        self._refitting: LatticeItem | None = None
        self._filling = False
        self._open: tuple[Face, ...] = ()
        self._connect()

    def _connect(self) -> None:
        self.around.activated.connect(self._take_bounds)
        self.margin.valueChanged.connect(self._take_bounds)
        self.dimension.activated.connect(self._take_bounds)
        self.rotated.toggled.connect(self._on_rotated)
        self.align.clicked.connect(self._align)
        for angle in self.angles:
            angle.valueChanged.connect(self._take_bounds)
        for box in (*self.counts, *self.degrees, self.frozen):
            box.valueChanged.connect(self._show)
        self.spacing.activated.connect(self._show)
        self.name.textChanged.connect(self._show)
        for edit in (*self.low, *self.high):
            edit.textEdited.connect(self._on_typed)
        self.make.clicked.connect(self._create)
        self.cancel.clicked.connect(self.stop)
        self.footer.installEventFilter(self)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Return and Esc do what they do in a dialog; fields have taken what is theirs."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._create()
        elif event.key() == Qt.Key.Key_Escape:
            self.stop()
        else:
            super().keyPressEvent(event)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Esc on the buttons, which lie outside this form."""
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress:
            self.keyPressEvent(event)
            return event.isAccepted()
        return super().eventFilter(watched, event)

    # ---- beginning and end ------------------------------------------------------------------

    def start(self, around: str = "", marker: str = "") -> None:
        """Begin with a lattice around everything, or a body's key, or a marker of it."""
        document = self._studio.document
        self._filling = True
        self._refitting = None
        self._offer((around, marker) if around else self._walls())
        flat = bool(document.model.bodies) and all(
            body.mesh.dimension == 2 for body in document.model.bodies
        )
        self.dimension.setCurrentIndex(1 if flat else 0)
        for axis, (count, degree) in enumerate(((6, 3), (4, 3), (4, 3))):
            self.counts[axis].setValue(count)
            self.degrees[axis].setValue(degree)
        self.margin.setValue(5.0)
        self.rotated.setChecked(False)
        self.frozen.setValue(0)
        self.hint.begin()
        self.name.setText(document.model.free_name("Lattice"))
        self.make.setText("&Create")
        self._filling = False
        self._take_bounds()
        self.around.setFocus(Qt.FocusReason.OtherFocusReason)

    def _walls(self) -> tuple[str, str]:
        """Key and marker of the wall in a mesh with a far field; nothing if there is none."""
        document = self._studio.document
        for body in document.model.bodies:
            names = walls(document.surface(body.key), document.points(body.key))
            if len(names) == 1:
                return body.key, names[0]
        return "", ""

    def refit(self, item: LatticeItem) -> None:
        """Begin with the values of an undeformed lattice."""
        self.start()
        self._filling = True
        self._refitting = item
        rest = item.rest
        self.dimension.setCurrentIndex(3 - rest.dimension)
        for axis in range(rest.dimension):
            self.counts[axis].setValue(rest.shape[axis])
            self.degrees[axis].setValue(rest.degrees[axis])
            self.low[axis].put(float(rest.domain[axis, 0]))
            self.high[axis].put(float(rest.domain[axis, 1]))
        straight = np.array_equal(rest.axes, np.eye(3)[: rest.dimension])
        self.rotated.setChecked(not straight and rest.dimension == 3)
        if not straight and rest.dimension == 3:
            for box, angle in zip(self.angles, angles_of(rest.axes), strict=True):
                box.setValue(angle)
        self.frozen.setValue(item.frozen)
        self.hint.begin(advising=False)
        self._seat({})
        self._open = tuple((axis, side) for axis, side in item.open_faces)
        self.name.setText(item.name)
        self.around.setCurrentIndex(self.around.findData(TYPED))
        self.make.setText("Fi&t anew")
        self._filling = False
        self._show()

    def stop(self) -> None:
        """End without a lattice."""
        self._studio.state.put_preview(None)
        self._finished()

    def _create(self) -> None:
        draft = self.draft()
        if draft.problems():
            return
        command: CreateBox | Refit = draft.command()
        if self._refitting is not None:
            command = Refit(self._refitting.key, draft.command())
        self._studio.state.put_preview(None)
        self._filling = True  # what the command changes is no reason to show the form anew
        try:
            done = self._studio.do(command)
        finally:
            self._filling = False
        if done:
            self._finished()
        else:
            self._show()

    # ---- sources of bounds ------------------------------------------------------------------

    def keep_up(self) -> None:
        """Offer what there is now: bodies come, go and are renamed while the form is open."""
        if self._filling:
            return
        model, source = self._studio.document.model, self.around.currentData()
        lost = self._refitting is not None and self._refitting.key not in {
            item.key for item in model.lattices
        }
        if lost or not model.bodies:
            self.stop()
            return
        self._offer(source)
        self._take_bounds()

    def _offer(self, source: object) -> None:
        """List all there is to lay a lattice around; choose a source, or everything."""
        self.around.clear()
        self.around.addItem("Everything", ("", ""))
        for body in self._studio.document.model.bodies:
            self.around.addItem(body.name, (body.key, ""))
            for name in self._studio.document.surface(body.key).markers:
                self.around.addItem(f"{body.name}: {name}", (body.key, name))
        self.around.addItem("Typed bounds", TYPED)
        for number in range(self.around.count()):
            if self.around.itemData(number) == source:
                self.around.setCurrentIndex(number)

    def _points(self) -> Array | None:
        """Points to lay the lattice around, as they are now; None for typed bounds."""
        source = self.around.currentData()
        if source == TYPED:
            return None
        document = self._studio.document
        if not source[0]:
            clouds = [document.points(body.key) for body in document.model.bodies]
            return np.concatenate(clouds) if clouds else None
        points = document.points(source[0])
        return points[document.surface(source[0]).marker_points(source[1])] if source[1] else points

    def _seat(self, faces: dict[Face, str]) -> None:
        """Take note of the faces that lie on planes: nothing is frozen there."""
        self._open = tuple(faces)
        say(self.seat, seat_sentence(faces))

    def _planes(self) -> tuple[Plane, ...]:
        """Planes where the mesh ends that the lattice is laid around."""
        model, source = self._studio.document.model, self.around.currentData()
        return planes_of(model.body(source[0]).mesh) if source[0] else planes_in(model)

    def _take_bounds(self) -> None:
        if self._filling:
            return
        points, d = self._points(), self.dimension.currentData()
        self._seat({})
        if points is not None and len(points):
            frame = Frame.of(self.draft().axes, d)
            bounds = frame.bounds(points, self.margin.value() / 100)
            low, high, faces = seated(frame, bounds, points, self._planes())
            self._seat(faces)
            for axis in range(d):
                self.low[axis].put(float(low[axis]))
                self.high[axis].put(float(high[axis]))
        self._show()

    def _on_typed(self) -> None:
        self.around.setCurrentIndex(self.around.findData(TYPED))
        self._seat({})
        self._show()

    def _on_rotated(self, on: bool) -> None:
        self._frame_box.setVisible(on)
        self._take_bounds()

    def _align(self) -> None:
        points = self._points()
        if points is None:
            clouds = [
                self._studio.document.points(b.key) for b in self._studio.document.model.bodies
            ]
            points = np.concatenate(clouds)
        axes = principal_frame(points, self.dimension.currentData() < 3)
        self._filling = True
        for box, angle in zip(self.angles, angles_of(axes), strict=True):
            box.setValue(angle)
        self._filling = False
        self._take_bounds()

    # ---- showing ----------------------------------------------------------------------------

    def draft(self) -> Draft:
        """What stands in the fields."""
        d = self.dimension.currentData()
        turned = tuple(box.value() for box in self.angles) if self.rotated.isChecked() else None
        return Draft(
            self.name.text(),
            tuple(box.value() for box in self.counts[:d]),
            tuple(box.value() for box in self.degrees[:d]),
            tuple(edit.value for edit in self.low[:d]),
            tuple(edit.value for edit in self.high[:d]),
            turned,  # type: ignore[arg-type]
            self.spacing.currentData(),
            self.frozen.value(),
            self._open,
        )

    def _show(self) -> None:
        if self._filling:
            return
        draft = self.draft()
        problems = draft.problems()
        lattice = None
        if not problems:
            try:
                lattice = draft.command().lattice
            except InputError as error:
                problems["other"] = str(error)
        if self.hint.look(lattice, self._open):
            return  # it has set the frozen layers, and all was shown anew
        for key, label in self.notes.items():
            say(label, sentence(problems[key]) if key in problems else "")
        self._mark(problems, len(draft.counts))
        self.make.setEnabled(not problems)
        self._studio.state.put_preview(lattice, self.frozen.value(), self._open)
        say(self.inside, "" if lattice is None else self._count(lattice))

    def _mark(self, problems: dict[str, str], d: int) -> None:
        self.margin.setEnabled(self.around.currentData() != TYPED)
        self.name.setEnabled(self._refitting is None)
        for axis in range(3):
            for widget in (
                self._letters[axis],
                self.counts[axis],
                self.degrees[axis],
                self.low[axis],
                self.high[axis],
            ):
                widget.setVisible(axis < d)
            for edit in (self.low[axis], self.high[axis]):
                edit.mark(f"bounds {axis}" in problems)

    def _count(self, lattice: Lattice) -> str:
        document, total, within = self._studio.document, 0, 0
        for body in document.model.bodies:
            points = document.points(body.key)
            total += len(points)
            within += int(inside_box(lattice, points).sum())
        return f"{within:,} of {total:,} displayed points lie inside.".replace(",", "\u202f")
