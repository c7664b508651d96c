"""The bar under the toolbar: across which axis the section is, and where."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QLabel, QSlider, QToolBar

from ffdstudio.gui.panels.fields import NumberEdit
from ffdstudio.gui.sections import middle, reach
from ffdstudio.gui.state import SectionPlane
from ffdstudio.gui.studio import Studio
from ffdstudio.gui.subscriptions import Listening
from ffdstudio.gui.theme import Theme

STEPS = 400
LETTERS = "XYZ"


class SectionBar(QToolBar):
    """Axis and place of the section; shown while there is one."""

    def __init__(self, studio: Studio) -> None:
        super().__init__("Section")
        self.setObjectName("section")
        self._studio = studio
        self.axis, self.place = QComboBox(), QSlider(Qt.Orientation.Horizontal)
        self.letter = QLabel()
        self.number = NumberEdit("Place of the section", "Coordinate of the plane; Enter cuts")
        self.axis.addItems([f"across {letter}" for letter in LETTERS])
        self.axis.setAccessibleName("Axis of the section")
        self.place.setAccessibleName("Slider for the place of the section")
        self.place.setRange(0, STEPS)
        self.place.setFixedWidth(180)
        self.number.setFixedWidth(80)
        for widget in (QLabel(" Section "), self.axis, self.place, self.letter, self.number):
            self.addWidget(widget)
        self.axis.activated.connect(self._turn)
        self.place.valueChanged.connect(self._slide)
        self.number.entered.connect(self._cut_at)
        self.number.refused.connect(lambda reason: studio.say(f"Place of the section: {reason}"))
        self._listening = Listening(
            (studio.state.shown_changed, self.fill),
            (studio.document.structure_changed, self._on_structure),
        )
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
        if section is None:
            return
        low, high = reach(self._studio.document, section.axis)
        self.axis.setCurrentIndex(section.axis)
        self.letter.setText(f"  {LETTERS[section.axis].lower()} = ")
        if not (self.number.hasFocus() and self.number.isModified()):
            self.number.put(section.at)
        self.place.setEnabled(high > low)
        if high > low:
            self.place.blockSignals(True)
            self.place.setValue(round(STEPS * (section.at - low) / (high - low)))
            self.place.blockSignals(False)

    def _on_structure(self) -> None:
        """Another mesh may lie elsewhere: do not leave the plane beside it."""
        section = self._studio.state.shown.section
        if section is None:
            return
        low, high = reach(self._studio.document, section.axis)
        if low < high and not low <= section.at <= high:
            self._studio.state.show(section=middle(self._studio.document, section.axis))
        self.fill()

    # ---- what the user does -----------------------------------------------------------------

    def _turn(self, axis: int) -> None:
        self._put(middle(self._studio.document, axis))

    def _slide(self, step: int) -> None:
        axis = self.axis.currentIndex()
        low, high = reach(self._studio.document, axis)
        self._put(SectionPlane(axis, low + (high - low) * step / STEPS))

    def _cut_at(self, place: float) -> None:
        """Cut at a typed coordinate, which may also lie beside the mesh."""
        self._put(SectionPlane(self.axis.currentIndex(), place))

    def _put(self, section: SectionPlane) -> None:
        if self._studio.state.shown.section is not None:
            self._studio.state.show(section=section)
