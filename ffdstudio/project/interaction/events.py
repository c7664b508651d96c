"""What the mouse and the keyboard did, without any window toolkit."""

from __future__ import annotations

from dataclasses import dataclass

from ffdstudio.project.view.camera import Camera


@dataclass(frozen=True)
class PointerEvent:
    """One thing that happened over the viewport.

    Attributes
    ----------
    kind : str
        ``press``, ``move``, ``release``, ``wheel``, ``key``; ``lost`` when the window lost
        the mouse or the focus, ``cancel`` to abort what is under way, ``again`` when only what
        is known of the drag has changed.
    camera : Camera
        As it was then.
    x, y : float
        Pixels from the upper left corner, y down.
    button : str
        ``left``, ``middle`` or ``right``, of a press or release.
    shift, ctrl, alt : bool
    key : str
        ``X``, ``Escape``, ``Return``, ``Left``, ``PageUp``, ...
    steps : float
        Of the wheel, positive away from the user.
    """

    kind: str
    camera: Camera
    x: float = 0.0
    y: float = 0.0
    button: str = ""
    shift: bool = False
    ctrl: bool = False
    alt: bool = False
    key: str = ""
    steps: float = 0.0

    @property
    def at(self) -> tuple[float, float]:
        """The pixel."""
        return self.x, self.y

    def happened(self, kind: str, what: str) -> bool:
        """Whether this is the press or release of a button, or the press of a key."""
        return self.kind == kind and what == (self.key if kind == "key" else self.button)
