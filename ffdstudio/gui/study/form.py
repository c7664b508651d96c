"""The form of a study: from its fields comes a `Plan`."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QGroupBox,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.gui.panels.fields import NumberEdit
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.study.limits import LimitsEdit
from ffdstudio.gui.study.plots import choice, narrow
from ffdstudio.optimize.geometry.sections import is_naca
from ffdstudio.project.model import Model
from ffdstudio.project.studies.airfoils import profiles
from ffdstudio.project.studies.plan import NEW, PLANE, Plan

OBJECTIVES = {
    "contour": "Match a contour",
    "pressure": "Match a contour's pressure",
    "lift": "Reach a lift",
    "surface": "Match a surface",
    "program": "Ask a program",
}
METHODS = {
    "gauss-newton": "Gauss-Newton",
    "minimax": "Least largest error",
    "lbfgs": "L-BFGS",
    "slsqp": "SLSQP (constraints)",
    "cg": "Conjugate gradients",
    "powell": "Conjugate directions (Powell)",
}
METRICS = {"h1": "H1 (smooth)", "l2": "L2", "none": "None: plain control points"}
INDICATORS = {
    "gain": "Gain",
    "interval": "Energy of the interval",
    "gradient": "Gradient of new points",
    "": "None: regular lattice",
}
EXAMPLES = {
    "contour": "file, or naca2412",
    "pressure": "file, or naca2412",
    "surface": "mesh file",
    "program": "python3 ./solver.py",
}
RESIDUAL_METHODS = ("gauss-newton", "minimax")
TARGETS = (
    "Contours and meshes (*.dat *.txt *.stl *.obj *.ply *.vtk *.vtu *.su2 *.msh);;All files (*)"
)


class StudyForm(QWidget):
    """Fields in groups; emits `changed`. `plan` is what they say, None without a shape."""

    changed = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._shapes: list[tuple[str, str, bool]] = []
        self._frozen_of: tuple[object, int] = (NEW, 0)
        self._make_fields()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 4, 8, 4)
        layout.setSpacing(4)
        for group in (
            self._goal(),
            self._lattice(),
            self._constraints(),
            self._way(),
            self._refining(),
            self._budget(),
        ):
            layout.addWidget(group)
        layout.addStretch(1)
        self._connect()
        self._on_objective()

    # ---- fields -------------------------------------------------------------------------------

    def _make_fields(self) -> None:
        self.shape, self.objective = narrow(QComboBox()), choice(OBJECTIVES)
        self.target = QLineEdit("naca2412")
        self.target.setToolTip("Airfoil file, mesh, or the name of a NACA four-digit section")
        self.browse = QPushButton("…")
        self.browse.setFixedWidth(30)
        self.browse.setToolTip("Choose a file")
        self.browse.setAccessibleName("Choose a target file")
        self.sensitivity = QCheckBox("Writes derivatives")
        self.time_limit = _decimal(1, 10**6, 600, 60)
        self.time_limit.setDecimals(0)
        self.time_limit.setSuffix(" s")
        self.angle, self.lift = _decimal(-30, 30, 2.0, 0.5), _decimal(-5, 5, 0.5, 0.05)
        self.angle.setSuffix("°")
        self.lattice = narrow(QComboBox())
        self.columns, self.rows = _count(4, 200, 5), _count(2, 8, 2)
        self.room = _decimal(0.0, 5.0, 0.0, 0.05)
        self.frozen = _count(0, 9, 0)
        self.letters = [QCheckBox(letter) for letter in "xyz"]
        self.mirror = narrow(QComboBox())
        for text in ("No", "Along i", "Along j", "Along k"):
            self.mirror.addItem(text)
        self.limits = LimitsEdit()
        self.method, self.norm = choice(METHODS), choice(METRICS)
        self.carry = QCheckBox("Carr&y memory on")
        self.carry.setChecked(True)
        self.indicator = choice(INDICATORS)
        self.variables = _count(1, 5000, 70)
        self.insertions, self.every = _count(1, 50, 1), _count(0, 1000, 0)
        self.every.setSpecialValueText("when it pays")
        self.along = [QCheckBox(letter) for letter in "ijk"]
        self.row_wise = QCheckBox("Row by row")
        self.evaluations, self.iterations = _count(0, 10**6, 0), _count(0, 10**6, 0)
        for box in (self.evaluations, self.iterations):
            box.setSpecialValueText("no limit")
        self.tolerance = NumberEdit("Cost to reach", "Cost at which the study has ended")
        self.tolerance.setPlaceholderText("none")
        self._explain()

    def _explain(self) -> None:
        tips = {
            self.shape: "Airfoil or surface that the objective looks at",
            self.frozen: "Outermost layers of control points that stay",
            self.mirror: "Both ends of a direction move as mirror images",
            self.norm: "In which variables are made orthonormal: H1 suits flows, L2 fits",
            self.carry: "The quasi-Newton memory outlives refinements, exactly",
            self.indicator: "What says where a knot is worth most",
            self.variables: "Number of variables at which refinement ends",
            self.insertions: "Knots inserted at each refinement",
            self.every: "Iterations between two refinements",
            self.row_wise: "A new knot frees one row of control points only",
            self.evaluations: "Most evaluations of the objective",
            self.iterations: "Most iterations",
            self.columns: "Control points along the section at the start",
            self.rows: "Control points across the section",
            self.room: "How far a new lattice reaches above and below the section, in chords: "
            "more room lets a mesh around it follow without inverted cells",
            self.sensitivity: "The program leaves sensitivity.csv; else finite differences",
            self.time_limit: "A run of the program that takes longer ends the study",
        }
        for widget, tip in tips.items():
            widget.setToolTip(tip)

    # ---- groups -------------------------------------------------------------------------------

    def _goal(self) -> QWidget:
        group, form = _group("Objective")
        row = QHBoxLayout()
        row.setSpacing(4)
        row.addWidget(self.target)
        row.addWidget(self.browse)
        form.addRow("Sha&pe", self.shape)
        form.addRow("&Objective", self.objective)
        form.addRow("&Target", row)
        form.labelForField(row).setBuddy(self.target)  # type: ignore[attr-defined]
        form.addRow("An&gle", self.angle)
        form.addRow("Lift", self.lift)
        form.addRow("Time limit", self.time_limit)
        form.addRow("", self.sensitivity)
        self._goal_form, self._target_row = form, row
        return group

    def _lattice(self) -> QWidget:
        group, form = _group("Variables")
        form.addRow("Latti&ce", self.lattice)
        form.addRow("Colum&ns", self.columns)
        form.addRow("Ro&ws", self.rows)
        form.addRow("Room across", self.room)
        form.addRow("Directions", _in_row(self.letters))
        form.addRow("Fro&zen layers", self.frozen)
        form.addRow("M&irrored", self.mirror)
        self._lattice_form = form
        return group

    def _constraints(self) -> QWidget:
        group, form = _group("Constraints")
        form.addRow(self.limits)
        return group

    def _way(self) -> QWidget:
        group, form = _group("Method")
        form.addRow("&Method", self.method)
        form.addRow("Met&ric", self.norm)
        form.addRow(self.carry)
        return group

    def _refining(self) -> QWidget:
        group, form = _group("Refinement")
        form.addRow("In&dicator", self.indicator)
        form.addRow("Varia&bles up to", self.variables)
        form.addRow("&Knots a cycle", self.insertions)
        form.addRow("After iterations", self.every)
        form.addRow("Along", _in_row(self.along))
        form.addRow("", self.row_wise)
        return group

    def _budget(self) -> QWidget:
        group, form = _group("Budget")
        form.addRow("Evaluations", self.evaluations)
        form.addRow("Iterations", self.iterations)
        form.addRow("Cost to reach", self.tolerance)
        return group

    def _connect(self) -> None:
        self.objective.currentIndexChanged.connect(self._on_objective)
        self.method.currentIndexChanged.connect(self._on_method)
        self.browse.clicked.connect(self._browse)
        self.lattice.currentIndexChanged.connect(self._take_frozen)
        boxes = (self.shape, self.lattice, self.mirror, self.norm, self.indicator)
        for box in boxes:
            box.currentIndexChanged.connect(self._tell)
        numbers = (
            self.columns, self.rows, self.frozen, self.variables, self.insertions, self.every,
            self.evaluations, self.iterations, self.angle, self.lift,
            self.room, self.time_limit,
        )  # fmt: skip
        for number in numbers:
            number.valueChanged.connect(self._tell)
        for check in (
            *self.letters,
            *self.along,
            self.carry,
            self.row_wise,
            self.sensitivity,
        ):
            check.toggled.connect(self._tell)
        self.target.editingFinished.connect(self._tell)
        self.tolerance.textEdited.connect(self._tell)
        self.limits.changed.connect(self._tell)

    # ---- keeping in step ----------------------------------------------------------------------

    def fill(self, model: Model) -> None:
        """Offer the shapes and lattices of a model."""
        shapes = [(b.key, p.marker, True) for b in model.bodies for p in profiles(b.mesh)]
        for body in model.bodies:
            if body.mesh.dimension == 3:
                solid = any(kind in body.mesh.cells for kind in ("triangle", "quad"))
                names = [""] if solid and body.mesh.faces is None else []
                shapes += [(body.key, name, False) for name in (*names, *body.mesh.markers)]
        if shapes != self._shapes:
            self._shapes = shapes
            texts = [f"{model.body(key).name} {marker}".strip() for key, marker, _ in shapes]
            _refill(self.shape, [(text, n) for n, text in enumerate(texts)])
            if shapes and not shapes[0][2]:
                self.objective.setCurrentIndex(self.objective.findData("surface"))
            elif shapes and self.objective.currentData() == "surface":
                self.objective.setCurrentIndex(0)
        lattices = [(item.name, item.key) for item in model.lattices]
        before = self.lattice.count()
        _refill(self.lattice, [("New, around the section", NEW), *lattices])
        if lattices and (before <= 1 or not self._plane):
            active = model.active or lattices[-1][1]
            self.lattice.setCurrentIndex(self.lattice.findData(active))
        self._take_frozen()
        self._tell()

    def _take_frozen(self) -> None:
        """Freeze what the chosen lattice has frozen, until the user says otherwise."""
        key, items = self.lattice.currentData(), self._studio.document.settled_model.lattices
        now = (key, next((item.frozen for item in items if item.key == key), 0))
        if now != self._frozen_of:
            self._frozen_of = now
            self.frozen.setValue(now[1])

    @property
    def has_sections(self) -> bool:
        """Whether there is a section to look at."""
        return any(plane for _, _, plane in self._shapes)

    @property
    def _plane(self) -> bool:
        return self.objective.currentData() in PLANE

    @property
    def _flat(self) -> bool:
        """Whether the chosen shape is a section."""
        index = self.shape.currentIndex()
        return self._shapes[index][2] if 0 <= index < len(self._shapes) else self._plane

    def _on_objective(self) -> None:
        """Show the fields of the objective, and the method and metric that suit it."""
        name = self.objective.currentData()
        fit = name in ("contour", "surface")
        self._goal_form.setRowVisible(self._target_row, name != "lift")
        self._goal_form.setRowVisible(self.angle, name in ("pressure", "lift"))
        self._goal_form.setRowVisible(self.lift, name == "lift")
        if name == "surface" and is_naca(self.target.text()):
            self.target.clear()
        self.target.setPlaceholderText(EXAMPLES.get(name, ""))
        for widget in (self.sensitivity, self.time_limit):
            self._goal_form.setRowVisible(widget, name == "program")
        self._goal_form.labelForField(self._target_row).setText(  # type: ignore[attr-defined]
            "Comm&and" if name == "program" else "&Target"
        )
        self.limits.for_sections(self._plane)
        self.method.setCurrentIndex(self.method.findData("gauss-newton" if fit else "lbfgs"))
        self.norm.setCurrentIndex(self.norm.findData("l2" if fit else "h1"))
        for k, box in enumerate(self.letters):
            box.setChecked(k == 1 if self._flat else True)
        self.letters[2].setEnabled(not self._flat)
        for k, box in enumerate(self.along):
            box.setChecked(k == 0 or not self._flat)
        self.along[2].setEnabled(not self._flat)
        self._tell()

    def _on_method(self) -> None:
        fit = self.objective.currentData() in ("contour", "surface")
        if self.method.currentData() in RESIDUAL_METHODS and not fit:
            self.method.setCurrentIndex(self.method.findData("lbfgs"))
        self._tell()

    def _tell(self) -> None:
        new = self.lattice.currentData() in (NEW, None) and self._flat
        self._lattice_form.setRowVisible(self.columns, new)
        self._lattice_form.setRowVisible(self.rows, new)
        self._lattice_form.setRowVisible(self.room, new)
        adaptive = bool(self.indicator.currentData())
        for widget in (self.variables, self.insertions, self.every, *self.along[:2], self.row_wise):
            widget.setEnabled(adaptive)
        self.changed.emit()

    def _browse(self) -> None:
        folder = Path(self._studio.settings.text("folder", str(Path.home())))
        paths = self._studio.asker.open_paths("Target", TARGETS, folder)
        if paths:
            self.target.setText(str(paths[0]))
            self._tell()

    # ---- what it says -------------------------------------------------------------------------

    @property
    def plan(self) -> Plan | None:
        """What the fields say."""
        index = self.shape.currentIndex()
        if not 0 <= index < len(self._shapes):
            return None
        key, marker, _ = self._shapes[index]
        return Plan(
            key, marker, self.lattice.currentData() or NEW, self.objective.currentData(),
            self.target.text().strip() if self.objective.currentData() != "lift" else "",
            self.angle.value(), self.lift.value(), self.limits.limits,
            "".join(box.text() for box in self.letters if box.isChecked() and box.isEnabled()),
            self.frozen.value(), (None, 0, 1, 2)[self.mirror.currentIndex()],
            self.method.currentData(), self.norm.currentData(),
            self.carry.isChecked(), self.indicator.currentData(), self.columns.value(),
            self.rows.value(),
            tuple(k for k, box in enumerate(self.along) if box.isChecked()) or (0,),
            self.variables.value(), self.insertions.value(), self.row_wise.isChecked(),
            self.every.value() or None, self.evaluations.value() or None,
            self.iterations.value() or None, self.tolerance.value,
            self.sensitivity.isChecked(), self.time_limit.value(), self.room.value(),
        )  # fmt: skip


def _refill(box: QComboBox, rows: list[tuple[str, object]]) -> None:
    """Offer other rows; the one that was chosen stays chosen if it is still there."""
    if [(box.itemText(k), box.itemData(k)) for k in range(box.count())] == rows:
        return
    chosen = box.currentData()
    box.blockSignals(True)
    box.clear()
    for text, data in rows:
        box.addItem(text, data)
    box.setCurrentIndex(max(0, box.findData(chosen)))
    box.blockSignals(False)


def _count(low: int, high: int, value: int) -> QSpinBox:
    box = QSpinBox()
    box.setRange(low, high)
    box.setValue(value)
    return box


def _decimal(low: float, high: float, value: float, step: float) -> QDoubleSpinBox:
    box = QDoubleSpinBox()
    box.setRange(low, high)
    box.setDecimals(4)
    box.setSingleStep(step)
    box.setValue(value)
    return box


def _group(title: str) -> tuple[QGroupBox, QFormLayout]:
    group = QGroupBox(title)
    form = QFormLayout(group)
    form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
    form.setContentsMargins(6, 6, 6, 6)
    form.setVerticalSpacing(4)
    form.setHorizontalSpacing(8)
    return group, form


def _in_row(boxes: list[QCheckBox]) -> QWidget:
    row = QWidget()
    layout = QHBoxLayout(row)
    layout.setContentsMargins(0, 0, 0, 0)
    for box in boxes:
        layout.addWidget(box)
    layout.addStretch(1)
    return row
