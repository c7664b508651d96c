"""The dialog for everything that goes wrong: what, why, and the way out."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication, QTextCursor
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QStyle,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.gui.errors import ErrorReport
from ffdstudio.gui.resources import program_icon


class ProblemDialog(QDialog):
    """Shows a `Problem`; a report, where there is one, can be unfolded and copied."""

    def __init__(self, problem: ErrorReport, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.problem = problem
        self.way: Callable[[], object] | None = None  # what the user wants next
        self.setWindowTitle("FFD Studio")
        self.setMinimumWidth(440)
        layout = QVBoxLayout(self)
        layout.addLayout(self._message())
        self.report = QPlainTextEdit(problem.details)
        self.report.setReadOnly(True)
        self.report.setMinimumSize(520, 220)
        self.report.setVisible(bool(problem.details) and not problem.warning)  # a log, asked for
        self.report.moveCursor(QTextCursor.MoveOperation.End)
        layout.addWidget(self.report)
        box = self._buttons()
        layout.addWidget(box)
        box.button(QDialogButtonBox.StandardButton.Close).setFocus()  # Enter has read it

    def _message(self) -> QHBoxLayout:
        line = QHBoxLayout()
        picture = QLabel()
        symbol = self.style().standardIcon(QStyle.StandardPixmap.SP_MessageBoxWarning)
        picture.setPixmap((symbol if self.problem.warning else program_icon()).pixmap(32, 32))
        line.addWidget(picture, 0, Qt.AlignmentFlag.AlignTop)
        texts = QVBoxLayout()
        for text, role in (
            (self.problem.title, "heading"),
            (self.problem.cause, ""),
            (self.problem.way_out, "muted"),
        ):
            label = QLabel(text)
            label.setTextFormat(Qt.TextFormat.PlainText)
            label.setWordWrap(True)
            label.setProperty("role", role)
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            label.setVisible(bool(text))
            texts.addWidget(label)
        line.addSpacing(8)
        line.addLayout(texts, 1)
        return line

    def _buttons(self) -> QDialogButtonBox:
        box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        box.rejected.connect(self.reject)
        for text, way in self.problem.ways:
            button = box.addButton(text, QDialogButtonBox.ButtonRole.ActionRole)
            button.clicked.connect(lambda _=False, chosen=way: self._go(chosen))
        close = box.button(QDialogButtonBox.StandardButton.Close)
        close.setDefault(True)
        if self.problem.details:
            role = QDialogButtonBox.ButtonRole.ActionRole
            if self.problem.warning:
                unfold: QPushButton = box.addButton("Show &report", role)
                unfold.setCheckable(True)
                unfold.toggled.connect(self._unfold)
            box.addButton("&Copy report", role).clicked.connect(self._copy)
        return box

    def _go(self, way: Callable[[], object]) -> None:
        self.way = way
        self.accept()

    def _unfold(self, on: bool) -> None:
        self.report.setVisible(on)
        self.adjustSize()

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self.problem.details)
