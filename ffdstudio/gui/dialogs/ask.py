"""Every question to the user goes through one `Asker`, so that tests can answer in his place."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtWidgets import QDialog, QFileDialog, QMessageBox, QWidget

from ffdstudio.gui.dialogs.problem import ProblemDialog
from ffdstudio.gui.errors import ErrorReport


@dataclass(frozen=True)
class Question:
    """A question with answers by key; the first one is the default, the last one cancels."""

    title: str
    text: str
    detail: str
    answers: tuple[tuple[str, str], ...]


class Asker:
    """Asks by modal dialogs over a window."""

    def __init__(self, parent: QWidget | None = None) -> None:
        self.parent = parent

    def open_paths(self, title: str, filters: str, folder: Path) -> list[Path]:
        """Files to open; empty if the user gives up."""
        names, _ = QFileDialog.getOpenFileNames(self.parent, title, str(folder), filters)
        return [Path(name) for name in names]

    def open_folder(self, title: str, folder: Path) -> Path | None:
        """Return a folder to open."""
        name = QFileDialog.getExistingDirectory(self.parent, title, str(folder))
        return Path(name) if name else None

    def save_path(self, title: str, filters: str, suggestion: Path) -> Path | None:
        """File to write; the first suffix of the filters where the user gives none."""
        name, _ = QFileDialog.getSaveFileName(self.parent, title, str(suggestion), filters)
        if not name:
            return None
        path = Path(name)
        return path if path.suffix else path.with_suffix(suggestion.suffix)

    def choose(self, question: Question) -> str:
        """Key of the answer."""
        box = QMessageBox(self.parent)
        box.setWindowTitle(question.title)
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(question.text)
        box.setInformativeText(question.detail)
        buttons = {}
        for number, (key, label) in enumerate(question.answers):
            last = number == len(question.answers) - 1
            role = QMessageBox.ButtonRole.RejectRole if last else QMessageBox.ButtonRole.AcceptRole
            buttons[key] = box.addButton(label, role)
        box.setDefaultButton(buttons[question.answers[0][0]])
        box.setEscapeButton(buttons[question.answers[-1][0]])
        box.exec()
        clicked = box.clickedButton()
        box.deleteLater()
        return next((key for key, b in buttons.items() if b is clicked), question.answers[-1][0])

    def tell(self, problem: ErrorReport) -> None:
        """Show a problem until it has been read."""
        dialog = ProblemDialog(problem, self.parent)
        self.run(dialog)
        if dialog.way is not None:
            dialog.way()

    def run(self, dialog: QDialog) -> bool:
        """Show a dialog until it is closed; whether it was accepted."""
        accepted = dialog.exec() == QDialog.DialogCode.Accepted
        dialog.deleteLater()
        return accepted
