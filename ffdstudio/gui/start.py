"""The page that is shown while nothing is open: open, recent files, examples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from ffdstudio.gui.panels.fields import note
from ffdstudio.gui.resources import folder, icon, program_icon
from ffdstudio.gui.theme import Theme

WIDTH = 720


@dataclass(frozen=True)
class Example:
    """A sample that comes with the program."""

    title: str
    text: str
    path: Path


EXAMPLES = (
    ("NACA 0012 section", "Plane mesh around an airfoil", "naca0012.su2"),
    ("Wing", "Surface of a swept wing", "wing_skin.vtu"),
    ("Wing in air", "Volume mesh around the wing", "wing_air.su2"),
    ("Wing structure", "Ribs and spars that fit the wing", "wing_structure.vtu"),
)


def examples() -> list[Example]:
    """Samples that this installation has."""
    home = folder("sample_meshes")
    rows = [Example(title, text, home / name) for title, text, name in EXAMPLES]
    return [row for row in rows if row.path.exists()]


class StartPage(QScrollArea):
    """Three ways to begin; the window also takes dropped files."""

    def __init__(self, choose: Callable[[], None], open_path: Callable[[Path], None]) -> None:
        super().__init__()
        self._choose, self._open = choose, open_path
        self.setFrameShape(QScrollArea.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.tiles: list[QPushButton] = []

    def fill(self, recent: list[Path], theme: Theme) -> None:
        """Show recent files and examples."""
        self.tiles = []
        page = QWidget()
        column = QVBoxLayout()
        column.setSpacing(8)
        column.addLayout(self._head())
        column.addSpacing(10)
        start = self._tile("Open…", "A mesh, a lattice or a project", "folder-open-outline", theme)
        start.clicked.connect(lambda: self._choose())
        column.addWidget(start)
        column.addWidget(note("Or drop files anywhere in this window."))
        grid = QGridLayout()
        grid.setHorizontalSpacing(16)
        self._list(grid, 0, "Recent", [(p.name, _short(p.parent), p) for p in recent[:6]], theme)
        samples = [(e.title, e.text, e.path) for e in examples()]
        self._list(grid, 1, "Examples", samples, theme)
        column.addSpacing(8)
        column.addLayout(grid)
        column.addStretch(1)
        middle = QWidget()
        middle.setLayout(column)
        middle.setMaximumWidth(WIDTH)
        row = QHBoxLayout(page)
        row.addStretch(1)
        row.addWidget(middle, 20)
        row.addStretch(1)
        self.setWidget(page)

    def _head(self) -> QHBoxLayout:
        row = QHBoxLayout()
        picture = QLabel()
        picture.setPixmap(program_icon().pixmap(QSize(56, 56)))
        row.addWidget(picture)
        row.addSpacing(8)
        texts = QVBoxLayout()
        texts.setSpacing(0)
        texts.addWidget(note("FFD Studio", "title"))
        texts.addWidget(note("Deform shapes, and the meshes around them, by a lattice."))
        row.addLayout(texts, 1)
        return row

    def _list(
        self,
        grid: QGridLayout,
        column: int,
        title: str,
        rows: list[tuple[str, str, Path]],
        theme: Theme,
    ) -> None:
        grid.setColumnStretch(column, 1)
        grid.addWidget(note(title, "heading"), 0, column)
        for number, (name, text, path) in enumerate(rows, start=1):
            tile = self._tile(name, text, "file-outline", theme)
            tile.setToolTip(str(path))
            tile.clicked.connect(lambda _=False, chosen=path: self._open(chosen))
            grid.addWidget(tile, number, column)
        if not rows:
            grid.addWidget(note("Nothing yet."), 1, column)

    def _tile(self, name: str, text: str, symbol: str, theme: Theme) -> QPushButton:
        tile = QPushButton()
        tile.setProperty("role", "tile")
        tile.setAccessibleName(f"{name}, {text}")
        tile.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        row = QHBoxLayout(tile)
        row.setContentsMargins(10, 6, 10, 6)
        picture = QLabel()
        picture.setPixmap(icon(symbol, theme["muted"]).pixmap(QSize(22, 22)))
        row.addWidget(picture)
        texts = QVBoxLayout()
        texts.setSpacing(0)
        for line in (Elided(name, ""), Elided(text, "muted")):
            line.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
            texts.addWidget(line)
        row.addLayout(texts, 1)
        tile.setMinimumHeight(row.sizeHint().height())
        self.tiles.append(tile)
        return tile


class Elided(QLabel):
    """One line that is cut where it is too long: in the middle, or at its end."""

    def __init__(
        self, text: str, role: str, mode: Qt.TextElideMode = Qt.TextElideMode.ElideMiddle
    ) -> None:
        super().__init__(text)
        self._text, self._mode = text, mode
        self.setProperty("role", role)
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def put(self, text: str) -> None:
        """Show another text."""
        self._text = text
        self.setText(self.fontMetrics().elidedText(text, self._mode, self.width()))

    def resizeEvent(self, _event: object) -> None:
        self.put(self._text)


def _short(path: Path) -> str:
    home = Path.home()
    return f"~/{path.relative_to(home)}" if path.is_relative_to(home) else str(path)
