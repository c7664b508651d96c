"""The form that builds a lattice, with live preview in the picture."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent

from ffdstudio.engine import Lattice
from ffdstudio.engine.boxes import Frame
from ffdstudio.errors import InputError
from ffdstudio.gui.errors import sentence
from ffdstudio.gui.panels.boxform import BoxForm
from ffdstudio.gui.panels.boxsource import TYPED, BoxSource
from ffdstudio.gui.panels.draft import (
    Draft,
    angles_of,
    inside_box,
    principal_frame,
)
from ffdstudio.gui.panels.fields import say
from ffdstudio.gui.studio import Studio
from ffdstudio.project.checks.freezing import Face
from ffdstudio.project.checks.plane_snapping import faces_on, seat_sentence
from ffdstudio.project.commands import CreateBox, Refit
from ffdstudio.project.model import LatticeItem
from ffdstudio.project.placing.placement import Placement, Site, placed
from ffdstudio.project.placing.room import extents, wanted_move


class Builder(BoxForm):
    """Fields of a `Draft`; every change shows the lattice or says what is wrong."""

    def __init__(self, studio: Studio, finished: Callable[[], None]) -> None:
        super().__init__(studio)
        self._studio, self._finished = studio, finished
        self._refitting: LatticeItem | None = None
        self._filling = False
        self._open: tuple[Face, ...] = ()
        self._kept: set[Face] = set()  # bounds that were typed stay what they are
        self.source = BoxSource(studio.document, self.around)
        self._connect()

    def _connect(self) -> None:
        self.around.activated.connect(self._begin_anew)
        self.auto.toggled.connect(self._begin_anew)
        for margin in self.margins:
            margin.valueChanged.connect(self._on_margin)
        self.dimension.activated.connect(self._begin_anew)
        self.rotated.toggled.connect(self._on_rotated)
        self.align.clicked.connect(self._align)
        for angle in self.angles:
            angle.valueChanged.connect(self._take_bounds)
        for box in (*self.counts, *self.degrees):
            box.valueChanged.connect(self._take_bounds)
        self.frozen.valueChanged.connect(self._show)
        self.spacing.activated.connect(self._show)
        self.name.textChanged.connect(self._show)
        for side, edits in enumerate((self.low, self.high)):
            for axis, edit in enumerate(edits):
                edit.textEdited.connect(partial(self._on_typed, (axis, side)))
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
        self._kept.clear()
        self.source.offer((around, marker) if around else self.source.wall())
        self.dimension.setCurrentIndex(1 if self.source.flat else 0)
        for axis, (count, degree) in enumerate(((6, 3), (4, 3), (4, 3))):
            self.counts[axis].setValue(count)
            self.degrees[axis].setValue(degree)
        self.auto.setChecked(True)
        self.rotated.setChecked(False)
        self.frozen.setValue(0)
        self.hint.begin()
        self.name.setText(document.model.free_name("Lattice"))
        self.make.setText("&Create")
        self._filling = False
        self._take_bounds()
        self.around.setFocus(Qt.FocusReason.OtherFocusReason)

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
        self._open = tuple((axis, side) for axis, side in item.open_faces)
        self.name.setText(item.name)
        self.source.choose(TYPED)
        self.make.setText("Fi&t anew")
        self._filling = False
        self._show()

    def stop(self) -> None:
        """End without a lattice."""
        self._leave()
        self._finished()

    def _leave(self) -> None:
        self.reach.stop()
        self._studio.state.put_preview(None)

    def _create(self) -> None:
        draft = self.draft()
        if draft.problems():
            return
        command: CreateBox | Refit = draft.command()
        if self._refitting is not None:
            command = Refit(self._refitting.key, draft.command())
        self._leave()
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
        self.source.offer(source)
        self._take_bounds()

    def _begin_anew(self) -> None:
        """Another source of bounds: forget what was typed for the last one."""
        if not self._filling:
            self._kept.clear()
            self._take_bounds()

    def _on_margin(self) -> None:
        if not self._filling:
            self._put_auto(False)
            self._take_bounds()

    def _put_auto(self, on: bool) -> None:
        self.auto.blockSignals(True)
        self.auto.setChecked(on)
        self.auto.blockSignals(False)

    def _take_bounds(self) -> None:
        """Lay the lattice around its source, but for the bounds that were typed."""
        if self._filling:
            return
        site = self.source.site()
        if len(site.skin) and not self.source.typed:
            placement = self._placed(site)
            if placement is not None:
                self._put_bounds(placement)
        self._show()

    def _placed(self, site: Site) -> Placement | None:
        """Lattice around a site as the fields have it; None while they make none."""
        draft = self.draft()
        if draft.lacks_degree:
            return None
        margin = None if self.auto.isChecked() else [m.value() / 100 for m in self.margins]
        d = len(draft.counts)
        try:
            return placed(
                site, draft.counts, draft.degrees, draft.axes, draft.spacing,
                None if margin is None else margin[:d],
            )  # fmt: skip
        except InputError:  # said by `_show`, of the fields as they are
            return None

    def _put_bounds(self, placement: Placement) -> None:
        filling, self._filling = self._filling, True
        domain = placement.lattice.domain
        for axis in range(len(domain)):
            for side, edit in enumerate((self.low[axis], self.high[axis])):
                if (axis, side) not in self._kept:
                    edit.put(float(domain[axis, side]))
            if self.auto.isChecked():
                self.margins[axis].setValue(100 * float(placement.room[axis]))
        self._filling = filling

    def _on_typed(self, face: Face, _text: str) -> None:
        self._kept.add(face)
        self._show()

    def _seat(self, draft: Draft, site: Site) -> None:
        """Find the faces that lie on planes, typed or not: nothing is frozen there."""
        frame = Frame.of(draft.axes, len(draft.counts))
        bounds = [np.zeros(3), np.zeros(3)]
        for corner, values in zip(bounds, (draft.lower, draft.upper), strict=True):
            corner[: len(values)] = [0.0 if v is None else v for v in values]
        faces = faces_on(frame, bounds[0], bounds[1], site.planes)
        if self._refitting is None:
            self._open = tuple(faces)
        say(self.seat, seat_sentence({face: faces[face] for face in self._open if face in faces}))

    def _on_rotated(self, on: bool) -> None:
        self._frame_box.setVisible(on)
        self._begin_anew()

    def _align(self) -> None:
        points = self.source.site().skin
        axes = principal_frame(points, self.dimension.currentData() < 3)
        self._filling = True
        for box, angle in zip(self.angles, angles_of(axes), strict=True):
            box.setValue(angle)
        self._filling = False
        self._begin_anew()

    # ---- showing ----------------------------------------------------------------------------

    def draft(self) -> Draft:
        """What stands in the fields."""
        d = self.dimension.currentData()
        axes = self.source.plane_axes()
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
            None if axes is None else tuple(map(tuple, axes.tolist())),
        )

    def _show(self) -> None:
        if self._filling:
            return
        draft, site = self.draft(), self.source.site()
        self._seat(draft, site)
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
        if lattice is None or not len(site.skin):
            self.reach.stop()
            return
        sizes = extents(Frame.of(draft.axes, len(draft.counts)), site.skin)
        planes = dict.fromkeys(self._open, "")
        found = Placement(lattice, planes, 0, [], np.zeros(0), wanted_move(sizes))
        self.reach.look(site, found, draft.frozen)

    def _mark(self, problems: dict[str, str], d: int) -> None:
        for axis, margin in enumerate(self.margins):
            margin.setEnabled(not self.source.typed)
            margin.setVisible(axis < d)
        self.auto.setEnabled(not self.source.typed)
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
