"""The form of a study: its fields are those of the catalog, what they say is a `StudySpec`.

1. What the form does not offer it keeps: a case that was loaded loses nothing by being shown.
2. What suits an objective (method, points, directions) is proposed when the user chooses one,
   never behind his back later on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QFormLayout, QGroupBox, QVBoxLayout, QWidget

from ffdstudio.errors import InputError
from ffdstudio.gui.errors import sentence
from ffdstudio.gui.panels.fields import note, say
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.constraints import ConstraintsEdit
from ffdstudio.gui.study.editors import Combo, Spin
from ffdstudio.gui.study.partform import KindForm, PartForm, form_layout
from ffdstudio.gui.study.plots import narrow
from ffdstudio.meshes.quasi2d import is_plane
from ffdstudio.optimize.build.place import given, is_given
from ffdstudio.optimize.build.shape import AIRFOILS, POINTS
from ffdstudio.optimize.catalog.indicators import INDICATORS
from ffdstudio.optimize.catalog.methods import METHODS
from ffdstudio.optimize.catalog.metrics import METRICS
from ffdstudio.optimize.catalog.objectives import OBJECTIVES
from ffdstudio.optimize.geometry.profiles import profiles
from ffdstudio.optimize.geometry.sections import FIT_POINTS, is_naca
from ffdstudio.optimize.methods.base import MethodSpec
from ffdstudio.optimize.methods.descent import Lbfgs
from ffdstudio.optimize.methods.gauss_newton import GaussNewton
from ffdstudio.optimize.methods.slsqp import Slsqp
from ffdstudio.optimize.spec.goals import ObjectiveSpec
from ffdstudio.optimize.spec.parts import BudgetSpec, LatticeSpec, ShapeSpec, VariablesSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project.model import Model

LABELS = {
    **{metric.name: metric.title for metric in METRICS},
    **{indicator.name: indicator.title for indicator in INDICATORS},
    **{letter: f"Along {letter}" for letter in "ijk"},
    "chord": "Chord",
    "tolerance": "Kulfan's tolerance",
}
TARGETS = (
    "Contours and meshes (*.dat *.txt *.stl *.obj *.ply *.vtk *.vtu *.su2 *.msh);;All files (*)"
)
NEW = ""
COLUMNS, ROWS, MARGIN = 5, 2, (0.01, 0.05)
FIRST_TARGET = "naca2412"


@dataclass(frozen=True)
class _Offered:
    """A shape that can be chosen."""

    text: str
    shape: ShapeSpec
    flat: bool


class StudyForm(QWidget):
    """Fields in groups; emits `changed`. `spec` is what they say."""

    changed = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._shapes: list[_Offered] = []
        self._base: StudySpec | None = None
        self._frozen_of: tuple[object, int] = (NEW, 0)
        self._make()
        column = QVBoxLayout(self)
        column.setContentsMargins(8, 4, 8, 4)
        column.setSpacing(4)
        for group in self._groups():
            column.addWidget(group)
        column.addWidget(self.problem)
        column.addStretch(1)
        self._connect()
        self._propose()

    def _make(self) -> None:
        labels, browse = LABELS, self._browse
        self.shape, self.lattice = narrow(Combo()), narrow(Combo())
        self.shape.setToolTip("Airfoil or surface that the objective looks at")
        self.section = PartForm(ShapeSpec, labels, browse)
        self.objective = KindForm(OBJECTIVES, "&Objective", labels, browse)
        self.columns, self.rows = _count(2, 1000, COLUMNS), _count(2, 1000, ROWS)
        self.columns.setToolTip("Control points along the section at the start")
        self.rows.setToolTip("Control points across the section")
        self.box = PartForm(LatticeSpec, labels, browse)
        self.variables = PartForm(VariablesSpec, labels, browse)
        self.limits = ConstraintsEdit(labels, browse)
        self.method = KindForm(METHODS, "&Method", labels, browse)
        self.refinement = PartForm(RefinementSpec, labels, browse)
        self.budget = PartForm(BudgetSpec, labels, browse)
        self.problem = note(role="problem")
        self._trigger = self.method_kind.trigger

    def _groups(self) -> list[QGroupBox]:
        goal, goal_form = _group("Objective")
        goal_form.addRow("Sha&pe", self.shape)
        goal_form.addRow(self.objective)
        goal_form.addRow(self.section)
        moving, form = _group("Variables")
        form.addRow("Latti&ce", self.lattice)
        form.addRow("Colum&ns", self.columns)
        form.addRow("Ro&ws", self.rows)
        form.addRow(self.box)
        form.addRow(self.variables)
        self._lattice_form = form
        kept, kept_form = _group("Constraints")
        kept_form.addRow(self.limits)
        way, way_form = _group("Method")
        way_form.addRow(self.method)
        self.refine, refine_form = _group("Refinement")
        self.refine.setCheckable(True)
        self.refine.setToolTip("Whether the lattice adapts itself; else it stays regular")
        refine_form.addRow(self.refinement)
        least, least_form = _group("Budget")
        least_form.addRow(self.budget)
        return [goal, moving, kept, way, self.refine, least]

    def _connect(self) -> None:
        self.shape.currentIndexChanged.connect(self._on_shape)
        self.objective.chosen.connect(self._propose)
        self.method.chosen.connect(self._on_method)
        self.lattice.currentIndexChanged.connect(self._on_lattice)
        self.limits.added.connect(self._on_constraint)
        self.refine.toggled.connect(self._tell)
        for number in (self.columns, self.rows):
            number.valueChanged.connect(self._tell)
        for part in (
            self.section, self.objective, self.box, self.variables, self.limits, self.method,
            self.refinement, self.budget,
        ):  # fmt: skip
            part.edited.connect(self._tell)

    # ---- keeping in step ----------------------------------------------------------------------

    def fill(self, model: Model) -> None:
        """Offer the shapes and lattices of a model."""
        shapes = [*_offered(model), *self._own_shape(model)]
        if shapes != self._shapes:
            first = not self._shapes
            self._shapes = shapes
            _refill(self.shape, [(one.text, _part_of(one.shape)) for one in shapes])
            self._offer_objectives(first)
        before = self.lattice.count()
        rows = [("New, around the section", NEW), *self._own_lattice()]
        rows += [(item.name, given(item.key)) for item in model.lattices]
        _refill(self.lattice, rows)
        if model.lattices and (before <= 1 or not self.flat):
            active = model.active or model.lattices[-1].key
            self.lattice.setCurrentIndex(self.lattice.findData(given(active)))
        self._take_frozen()
        self._tell()

    def _own_shape(self, model: Model) -> list[_Offered]:
        """The shape of a case that was loaded, if it is none of the document's."""
        if self._base is None or is_given(self._base.shape.source):
            return []
        shape = self._base.shape
        text = f"{Path(shape.source).name} {shape.marker}".strip()
        by_name = is_naca(shape.source) or shape.source.lower().endswith(AIRFOILS)
        return [_Offered(text, shape, by_name or self._base.objective.needs == "section")]

    def _own_lattice(self) -> list[tuple[str, str]]:
        file = "" if self._base is None else self._base.lattice.file
        return [(Path(file).name, file)] if file and not is_given(file) else []

    def _offer_objectives(self, first: bool) -> None:
        if not self._shapes:
            return
        other = "surface" if self.flat else "section"
        before = self.objective.kind
        self.objective.offer([kind for kind in OBJECTIVES if kind.needs != other])
        self.limits.for_sections(self.flat)
        if first or self.objective.kind is not before:
            self._propose()

    def _on_shape(self) -> None:
        self._offer_objectives(first=False)
        self._tell()

    def _take_frozen(self) -> None:
        """Freeze what the chosen lattice has frozen, until the user says otherwise."""
        key, items = self.lattice.currentData(), self._studio.document.settled_model.lattices
        now = (key, next((item.frozen for item in items if given(item.key) == key), 0))
        if now != self._frozen_of:
            self._frozen_of = now
            self.variables.editors["frozen"].put(now[1])

    def _on_lattice(self) -> None:
        self._take_frozen()
        self._tell()

    @property
    def has_sections(self) -> bool:
        """Whether there is a section to look at."""
        return any(one.flat for one in self._shapes)

    @property
    def chosen(self) -> _Offered | None:
        """The shape that is chosen."""
        index = self.shape.currentIndex()
        return self._shapes[index] if 0 <= index < len(self._shapes) else None

    @property
    def flat(self) -> bool:
        """Whether the chosen shape is a section."""
        return True if self.chosen is None else self.chosen.flat

    @property
    def objective_kind(self) -> type[ObjectiveSpec]:
        """Kind of the objective."""
        kind = self.objective.kind
        assert issubclass(kind, ObjectiveSpec)
        return kind

    @property
    def method_kind(self) -> type[MethodSpec]:
        """Kind of the method."""
        kind = self.method.kind
        assert issubclass(kind, MethodSpec)
        return kind

    # ---- what suits an objective ------------------------------------------------------------

    def _propose(self) -> None:
        """Propose what suits the objective: method, points, directions."""
        goal = self.objective_kind
        points = self.section.editors["points"]
        points.put(FIT_POINTS if goal.by_points else POINTS if goal.needs == "section" else None)
        target = self.objective.form.editors.get("target")
        if target is not None and goal.needs == "section" and not target.value():
            target.put(FIRST_TARGET)
        if not self.limits.rows:
            self.method.choose(GaussNewton if goal.residuals else Lbfgs)
            self._on_method()
        self.variables.editors["directions"].put(("y",) if self.flat else ("x", "y", "z"))
        axes = ("i",) if self.flat else ("i", "j", "k")
        self.refinement.editors["directions"].put(axes)
        self._tell()

    def _on_method(self) -> None:
        """Propose when refinement pays with the method, unless the user has said when."""
        before, now = self._trigger, self.method_kind.trigger
        every, slope = (self.refinement.editors[name] for name in ("iterations", "slope"))
        try:
            untouched = (every.value(), slope.value()) == tuple(before)
        except InputError:
            untouched = False
        if untouched or not self._base:
            every.put(now.iterations)
            slope.put(now.slope)
        self._trigger = now
        self._tell()

    def _on_constraint(self) -> None:
        """Take a method that keeps constraints, where the present one cannot."""
        if self.method_kind.residuals:
            self.method.choose(Slsqp)
            self._on_method()

    def _tell(self) -> None:
        new = self.lattice.currentData() in (NEW, None) and self.flat
        for row in (self.columns, self.rows, self.box):
            self._lattice_form.setRowVisible(row, new)
        self.section.setVisible(self.flat and not self.objective_kind.whole)
        say(self.problem, self.wrong)
        self.changed.emit()

    def _browse(self) -> str | None:
        folder = Path(self._studio.settings.text("folder", str(Path.home())))
        paths = self._studio.asker.open_paths("Target", TARGETS, folder)
        return str(paths[0]) if paths else None

    # ---- what it says -------------------------------------------------------------------------

    @property
    def spec(self) -> StudySpec | None:
        """What the fields say; None without a shape, or if one of them holds no value."""
        try:
            return self._spec()
        except InputError:
            return None

    @property
    def wrong(self) -> str:
        """What is wrong with the fields, in a sentence; empty if nothing is."""
        try:
            self._spec()
        except InputError as error:
            return sentence(str(error))
        return ""

    def _spec(self) -> StudySpec | None:
        chosen, base = self.chosen, self._base
        if chosen is None:
            return None
        shape = self.section.value(self._base_shape(chosen))
        own = base if base is not None else None
        return StudySpec(
            shape=shape,
            lattice=self._lattice(own),
            variables=self.variables.value(None if own is None else own.variables),
            objective=self.objective.value(None if own is None else own.objective),
            constraints=self.limits.value(),
            method=self.method.value(None if own is None else own.method),
            refinement=self._refinement(own),
            budget=self.budget.value(None if own is None else own.budget),
        )

    def _base_shape(self, chosen: _Offered) -> ShapeSpec:
        """The chosen shape, with what was loaded with it and is not offered."""
        base = self._base
        if base is None or _part_of(base.shape) != _part_of(chosen.shape):
            return chosen.shape
        return base.shape

    def _lattice(self, base: StudySpec | None) -> LatticeSpec:
        file = self.lattice.currentData() or NEW
        known = None if base is None else base.lattice
        counts = (self.columns.value(), self.rows.value())
        same = known is not None and known.file == file
        if known is not None and same and (file or (known.shape and known.shape[:2] == counts)):
            kept: LatticeSpec = self.box.value(known)
            return kept
        box: LatticeSpec = self.box.value(_new_box(counts))
        return box if not file else msgspec.structs.replace(box, file=file)

    def _refinement(self, base: StudySpec | None) -> RefinementSpec | None:
        if not self.refine.isChecked():
            return None
        known: RefinementSpec = self.refinement.value(None if base is None else base.refinement)
        return known

    # ---- what it shows ------------------------------------------------------------------------

    def put(self, spec: StudySpec) -> None:
        """Show a description; what the form does not offer it keeps."""
        self._base = spec
        self.fill(self._studio.document.settled_model)
        wanted = _part_of(spec.shape)
        places = [n for n, one in enumerate(self._shapes) if _part_of(one.shape) == wanted]
        self._silently(lambda: self._put(spec, places[0] if places else -1))
        self._tell()

    def _put(self, spec: StudySpec, place: int) -> None:
        self.shape.setCurrentIndex(place)
        self._offer_objectives(first=False)
        self.section.put(spec.shape)
        self.objective.put(spec.objective)
        self.lattice.setCurrentIndex(self.lattice.findData(spec.lattice.file))
        if spec.lattice.shape is not None and not spec.lattice.file:
            self.columns.setValue(spec.lattice.shape[0])
            self.rows.setValue(spec.lattice.shape[1] if len(spec.lattice.shape) > 1 else 2)
        self.box.put(spec.lattice)
        self._take_frozen()
        self.variables.put(spec.variables)
        self.limits.for_sections(self.flat)
        self.limits.put(spec.constraints)
        self.method.put(spec.method)
        self._trigger = spec.method.trigger
        self.refine.setChecked(spec.refinement is not None)
        if spec.refinement is not None:
            self.refinement.put(spec.refinement)
        self.budget.put(spec.budget)

    def _silently(self, change: Callable[[], None]) -> None:
        widgets = (self.shape, self.lattice, self.columns, self.rows, self.refine)
        before = [widget.blockSignals(True) for widget in widgets]
        try:
            change()
        finally:
            for widget, blocked in zip(widgets, before, strict=True):
                widget.blockSignals(blocked)


# ---- parts ---------------------------------------------------------------------------------


def _offered(model: Model) -> list[_Offered]:
    """Sections and surfaces of the bodies of a model."""
    found = []
    for body in model.bodies:
        for profile in profiles(body.mesh):
            text = f"{body.name} {profile.marker}".strip()
            found.append(_Offered(text, _shape(body.key, profile.marker), True))
    for body in model.bodies:
        if body.mesh.dimension == 3 and not is_plane(body.mesh):
            solid = any(kind in body.mesh.cells for kind in ("triangle", "quad"))
            names = [""] if solid and body.mesh.faces is None else []
            for name in (*names, *body.mesh.markers):
                text = f"{body.name} {name}".strip()
                found.append(_Offered(text, _shape(body.key, name), False))
    return found


def _shape(key: str, marker: str) -> ShapeSpec:
    return ShapeSpec(source=given(key), marker=marker, normalise=False)


def _part_of(shape: ShapeSpec) -> tuple[str, str]:
    return shape.source, shape.marker


def _new_box(counts: tuple[int, int]) -> LatticeSpec:
    """Lattice around a section: cubic along it, of the highest degree across."""
    return LatticeSpec(
        shape=counts, degrees=(min(3, counts[0] - 1), min(20, counts[1] - 1)), margin=MARGIN
    )  # fmt: skip


def _refill(box: QComboBox, rows: Sequence[tuple[str, object]]) -> None:
    """Offer other rows; the one that was chosen stays chosen if it is still there."""
    if [(box.itemText(k), box.itemData(k)) for k in range(box.count())] == list(rows):
        return
    chosen = box.currentData()
    box.blockSignals(True)
    box.clear()
    for text, data in rows:
        box.addItem(text, data)
    places = [k for k, (_, data) in enumerate(rows) if data == chosen]
    box.setCurrentIndex(places[0] if places else 0)
    box.blockSignals(False)


def _count(low: int, high: int, value: int) -> Spin:
    box = Spin()
    box.setRange(low, high)
    box.setValue(value)
    return box


def _group(title: str) -> tuple[QGroupBox, QFormLayout]:
    group = QGroupBox(title)
    form = form_layout(group)
    form.setContentsMargins(6, 6, 6, 6)
    return group, form
