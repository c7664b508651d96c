"""What happens when a drag comes to the limit of the mesh, and what the limit is."""

from __future__ import annotations

from PySide6.QtWidgets import QComboBox, QFormLayout, QGroupBox, QVBoxLayout

from ffdstudio.gui.panels.fields import note
from ffdstudio.gui.studio import Studio
from ffdstudio.meshes.safety.limits import PRESETS, Limits
from ffdstudio.project.checks.guarding import DragGuard

MODES = {
    "stop": ("Stop at the limit", "A drag ends where the first cell would break the limit"),
    "warn": ("Warn", "The drag goes on, and the picture says that it has passed the limit"),
    "free": ("Free", "No guard: what a drag has done is told when it has ended"),
}
TITLES = {
    "inversion": "No inverted cell",
    "OpenFOAM": "OpenFOAM (checkMesh)",
    "boundary layer": "OpenFOAM and first layer",
}


def meaning(limits: Limits) -> str:
    """Say limits in words.

    Examples
    --------
    >>> meaning(Limits(first_layer=0.1))
    'no inverted cell, first-layer height within 10 %'
    """
    parts = ["no inverted cell"]
    if limits.non_orthogonality is not None:
        parts.append(f"non-orthogonality below {limits.non_orthogonality:g}°")
    if limits.face_skewness is not None:
        parts.append(f"face skewness below {limits.face_skewness:g}")
    if limits.first_layer is not None:
        parts.append(f"first-layer height within {100 * limits.first_layer:g} %")
    return ", ".join(parts)


class GuardBox(QGroupBox):
    """Two choices, which the settings remember."""

    def __init__(self, studio: Studio, warden: DragGuard) -> None:
        super().__init__("Guard of drags")
        self._studio, self._warden = studio, warden
        self.mode, self.limits, self.hint = QComboBox(), QComboBox(), note()
        for key, (text, tip) in MODES.items():
            self.mode.addItem(text, key)
            self.mode.setItemData(self.mode.count() - 1, tip, 3)  # ToolTipRole
        for key in PRESETS:
            self.limits.addItem(TITLES.get(key, key), key)
            self.limits.setItemData(self.limits.count() - 1, meaning(PRESETS[key]), 3)
        self.mode.setAccessibleName("What happens at the limit of a drag")
        self.limits.setAccessibleName("Limit of a drag")
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&At the limit", self.mode)
        form.addRow("Limi&t", self.limits)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.hint)
        self.mode.activated.connect(lambda: warden.set(mode=self.mode.currentData()))
        self.limits.activated.connect(lambda: warden.set(limits=self.limits.currentData()))
        warden.changed.connect(self.fill)
        self.fill()

    def close_box(self) -> None:
        """Stop listening."""
        self._warden.changed.disconnect(self.fill)

    def fill(self) -> None:
        """Show the choices and remember them."""
        warden, settings = self._warden, self._studio.settings
        self.mode.setCurrentIndex(self.mode.findData(warden.mode))
        self.limits.setCurrentIndex(self.limits.findData(warden.limits))
        self.mode.setToolTip(MODES[warden.mode][1])
        self.limits.setEnabled(warden.mode != "free")
        self.hint.setText(
            MODES[warden.mode][1]
            + ("" if warden.mode == "free" else f": {meaning(PRESETS[warden.limits])}")
            + "."
        )
        settings.put("guard", warden.mode)
        settings.put("guard_limits", warden.limits)
