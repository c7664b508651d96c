"""What the View and Help menus do."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ffdstudio.gui.action_table import ROWS
from ffdstudio.gui.actions import Actions
from ffdstudio.gui.dialogs.palette import Offer, Palette
from ffdstudio.gui.dialogs.sheet import ShortcutSheet
from ffdstudio.gui.navigation import AXIS_VIEWS, View, looking
from ffdstudio.gui.scene import Scene
from ffdstudio.gui.sections import middle
from ffdstudio.gui.studio import Studio
from ffdstudio.meshes.quasi2d import slab_of
from ffdstudio.project import commands as c
from ffdstudio.project.model import Body
from ffdstudio.project.view.looks import LookName


class ViewHandler:
    """The viewer's place and what he sees."""

    def __init__(
        self,
        studio: Studio,
        scene: Scene,
        set_theme: Callable[[str], None],
        reset: Callable[[], None],
    ) -> None:
        self._studio, self._scene = studio, scene
        self._set_theme, self.reset_layout = set_theme, reset
        self._kept: list[View] = []
        self._recalled = -1
        self.chosen_body: Callable[[], Body | None] = lambda: None

    def fit(self) -> None:
        """Show the shape, without the far field around it, and its lattices."""
        self._scene.viewport.fit(self._scene.shape_bounds())

    def fit_all(self) -> None:
        """Show everything, the far field as well."""
        self._scene.viewport.fit()

    def home(self) -> None:
        """Back to the first picture."""
        self._scene.go_home()

    def keep(self) -> None:
        """Remember where the viewer stands."""
        self._kept.append(self._scene.viewport.view)
        self._studio.say(f"View {len(self._kept)} is kept")

    def recall(self) -> None:
        """Go to the next view that was kept."""
        if not self._kept:
            self._studio.say("No view has been kept")
            return
        self._recalled = (self._recalled + 1) % len(self._kept)
        self._scene.viewport.view = self._kept[self._recalled]
        self._studio.say(f"View {self._recalled + 1} of {len(self._kept)}")

    def fit_selected(self) -> None:
        """Come close to the selected points, with some room around."""
        item = self._studio.document.model.active_lattice
        points = sorted(self._studio.document.selection)
        if item is None or not points:
            return
        places = item.current.control_points[tuple(np.array(points).T)]
        room = 0.15 * item.rest.diagonal
        bounds = np.array([places.min(axis=0) - room, places.max(axis=0) + room])
        self._scene.viewport.fit(bounds)

    def side(self, name: str) -> None:
        """Look at the same place from a side of `AXIS_VIEWS`, from as far away.

        Along an axis the projection is parallel: a side view is for comparing lengths.
        """
        viewport, bodies = self._scene.viewport, self._studio.document.model.bodies
        view = looking(*AXIS_VIEWS[name], viewport.view)
        view = replace(view, parallel=view.flat or name != "corner")
        slabs = [slab for body in bodies if (slab := slab_of(body.mesh)) is not None]
        if slabs:  # a section with depth may be looked at from any side, and turned then
            view = replace(view, flat=bool(abs(view.back @ slabs[0].normal) > 1 - 1e-9))
        viewport.view = view

    def parallel(self, on: bool) -> None:
        """Parallel or perspective projection."""
        self._scene.viewport.view = replace(self._scene.viewport.view, parallel=on)

    def switch(self, name: str, on: bool) -> None:
        """Draw something, or not; the names are those of `Shown`."""
        self._studio.state.show(**{name: on})

    def look(self, name: LookName) -> None:
        """What the colour of the bodies tells."""
        self._studio.state.show(look=name)

    def section(self, on: bool) -> None:
        """Cut volume meshes open."""
        self._studio.state.show(section=middle(self._studio.document) if on else None)

    def isolate(self) -> None:
        """Show the chosen body alone."""
        bodies = self._studio.document.model.bodies
        chosen = self.chosen_body() or bodies[0]
        if any(body.visible != (body is chosen) for body in bodies):
            self._studio.do(c.Isolate(chosen.key))

    def show_all(self) -> None:
        """Show all that is hidden."""
        model = self._studio.document.model
        markers = any(body.hidden_markers for body in model.bodies)
        if markers or not all(item.visible for item in model.items):
            self._studio.do(c.ShowAll())

    def light(self) -> None:
        """Light theme."""
        self._set_theme("light")

    def dark(self) -> None:
        """Dark theme."""
        self._set_theme("dark")


class HelpHandler:
    """Palette, sheet, log, about."""

    def __init__(self, studio: Studio, actions: Actions) -> None:
        self._studio, self._actions = studio, actions
        self.more: Callable[[], Iterable[Offer]] = lambda: ()  # what the table does not hold

    def palette(self) -> None:
        """Ask for a command and carry it out."""
        offers = [
            Offer(": ".join(filter(None, (row.menu, row.submenu))), action, row.tip)
            for row in ROWS
            if (action := self._actions.by_name[row.name]).objectName() != "help.palette"
        ]
        assert self._studio.asker.parent is not None
        dialog = Palette([*offers, *self.more()], self._studio.asker.parent)
        if self._studio.asker.run(dialog) and dialog.chosen is not None:
            dialog.chosen.trigger()

    def shortcuts(self) -> None:
        """Show the sheet of keys."""
        assert self._studio.asker.parent is not None
        self._studio.asker.run(ShortcutSheet(self._studio.asker.parent))

    def log(self) -> None:
        """Show the end of the log."""
        from ffdstudio.gui.errors import ErrorReport, log_path

        text = _tail(log_path())
        self._studio.asker.tell(
            ErrorReport("Log", f"Kept in {log_path()}", "" if text else "It is empty.", text, False)
        )

    def about(self) -> None:
        """Show version and licence."""
        from ffdstudio.gui.errors import ErrorReport
        from ffdstudio.version import __version__

        self._studio.asker.tell(
            ErrorReport(
                f"FFD Studio {__version__}",
                "Adaptive free-form deformation of geometry and CFD meshes. MIT licence.",
                warning=False,
            )
        )


def _tail(path: Path, size: int = 20_000) -> str:
    try:
        data = path.read_bytes()
    except OSError:
        return ""
    return data[-size:].decode("utf-8", "replace")
