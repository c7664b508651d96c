"""What the window shows beyond the document: nothing of it is saved in a project or undone.

Like the document it has signals, and views listen to it instead of to each other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from psygnal import Signal

from ffdstudio.project.view.looks import LookName

if TYPE_CHECKING:
    from ffdstudio.engine import Lattice


@dataclass(frozen=True)
class SectionPlane:
    """Plane through the volume: its normal as an axis (0, 1, 2), and where it meets that axis."""

    axis: int = 1
    at: float = 0.0


@dataclass(frozen=True)
class ShownOptions:
    """What is drawn, and how."""

    ghost: bool = False
    edges: bool = True
    inside: bool = False
    labels: bool = True
    net: bool = True
    section: SectionPlane | None = None
    outer: bool = False
    look: LookName = "shaded"
    before: bool = False


class WindowState:
    """Choices of the viewer, the lattice that is being built, and what the mouse is over."""

    shown_changed = Signal()
    preview_changed = Signal()
    hovered_changed = Signal()
    mode_changed = Signal()
    theme_changed = Signal()
    navigating_changed = Signal()

    def __init__(self) -> None:
        self.shown = ShownOptions()
        self.preview: Lattice | None = None
        self.preview_frozen = 0
        self.preview_open: tuple[tuple[int, int], ...] = ()
        self.hovered: tuple[int, ...] | None = None
        self.mode = "move"
        self.navigating = False
        self.soft = False
        self.mirror = -1
        self.radius: float | None = None  # of soft selection; None: a part of the lattice
        self.profile = "smooth"
        self.mirror_at = 0.0
        self.pivot = "centroid"

    def show(self, **changes: Any) -> None:
        """Change what is drawn; the names are the fields of `Shown`."""
        new = replace(self.shown, **changes)
        if new != self.shown:
            self.shown = new
            self.shown_changed.emit()

    def put_preview(
        self,
        lattice: Lattice | None,
        frozen: int = 0,
        open_faces: tuple[tuple[int, int], ...] = (),
    ) -> None:
        """Show a lattice that is being built; None when that is over."""
        self.preview, self.preview_frozen, self.preview_open = lattice, frozen, open_faces
        self.preview_changed.emit()

    def hover(self, point: tuple[int, ...] | None) -> None:
        """Control point of the active lattice under the mouse."""
        if point != self.hovered:
            self.hovered = point
            self.hovered_changed.emit()

    def navigate(self, on: bool) -> None:
        """Whether the viewer is turning the picture: what is large is drawn coarsely then."""
        if on != self.navigating:
            self.navigating = on
            self.navigating_changed.emit()

    def set_mode(self, mode: str) -> None:
        """What a drag does: "move", "box", "rotate" or "scale"."""
        if mode != self.mode:
            self.mode = mode
            self.mode_changed.emit()

    def spread(
        self,
        soft: bool | None = None,
        mirror: int | None = None,
        radius: float | None = None,
        profile: str | None = None,
        mirror_at: float | None = None,
        pivot: str | None = None,
    ) -> None:
        """Let near points, or those opposite the plane of an axis (-1 for none), follow."""
        self.soft = self.soft if soft is None else soft
        self.mirror = self.mirror if mirror is None else mirror
        self.radius = self.radius if radius is None else radius
        self.profile = self.profile if profile is None else profile
        self.mirror_at = self.mirror_at if mirror_at is None else mirror_at
        self.pivot = self.pivot if pivot is None else pivot
        self.mode_changed.emit()
