"""The document: the single truth that every view listens to.

1. What is edited, and how that is told, is in `editor`; files are read and written by `filing`;
   `body_views` keeps what is displayed up with the model. Here they become one.
2. Displayed points (see `followers`) are bound to the lattices when they appear and then
   follow at once; volume nodes follow by work started after *moved*. Nothing that happens
   in a frame knows how many nodes a volume has.
3. What is written is computed from the model alone (`followers.deformed`), never from what
   is displayed: a replay of the journal gives the same bytes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array, PathLike
from ffdstudio.errors import InputError
from ffdstudio.meshes.ways import Way
from ffdstudio.project import filing
from ffdstudio.project.body_views import Displays
from ffdstudio.project.editor import Editor
from ffdstudio.project.files.recovery import Left
from ffdstudio.project.followers import Follower
from ffdstudio.project.model import Model
from ffdstudio.project.running import Runner
from ffdstudio.project.view.surface import DisplaySurface
from ffdstudio.project.view.volume import DeformedVolume


class Document(Editor):
    """Bodies, lattices, selection, history, and the points that follow.

    Parameters
    ----------
    runner : Runner, optional
        Who runs long work; by default it is run at once.

    Attributes
    ----------
    model : Model
        Bodies and lattices as they are now, the preview of a drag included.
    history : History
        What was done, with labels; change it by `undo`, `redo` and `jump` only.
    journal : Journal
        The same as lines to replay.
    selection : frozenset of tuple of int
        Selected control points (i, j, k) of the active lattice; not part of the history.
    editing : Edit or None
        The drag under way.
    path : pathlib.Path or None
        The project file.
    records : StudyRecords
        Of the studies, which run for long and are no edits.
    sections : dict
        Other parts of the project file (studies, ...), kept as they are.
    ask : callable or None
        Called with a `ProjectFile` whose meshes are missing or changed; see `filing`.
    may_overwrite : callable or None
        Called with the project file when somebody else has written on it since: whether it is
        replaced all the same. Without an answer it is not.
    on_disk : tuple or None
        Stamp of the project file as it was read or written here (see `files.stamp`).
    may_replace : callable or None
        Called when a project has been read, if something was done in the meantime: whether it
        may go.

    Notes
    -----
    Signals, all on the document's thread:

    - ``moving()``, ``moved()``: see above.
    - ``structure_changed()``: bodies or lattices came, went, were renamed, hidden, coloured,
      refined or frozen, or another one became active.
    - ``selection_changed()``, ``history_changed()`` (also when saved).
    - ``volume_changed(key)``: `volume(key)` is known now, or is no longer.
    - ``problem(title, cause, doing)``: something that was asked for did not work; `doing` is
      "open", "save", "export" or "export lattice" when that can be tried with another file,
      "note" when it did work but not quite, else empty.
    - ``told(text)``: something that was asked for is done; for the status line.
    - ``filed(path)``: a mesh, lattice or project was read, or a project written.

    Examples
    --------
    >>> from ffdstudio.project.commands import CreateBox
    >>> document = Document()
    >>> document.do(CreateBox("Box", (0, 0, 0), (1, 1, 1), (4, 3, 3), (3, 2, 2)))
    >>> drag = document.edit([(3, 2, 2)])
    >>> drag.translate([0.5, 0, 0])
    >>> drag.commit()
    >>> document.history.labels
    ['Create Box 4×3×3', 'Move point (3, 2, 2)']
    """

    def __init__(self, runner: Runner | None = None) -> None:
        super().__init__(runner)
        self._displays = Displays(self)

    # ---- what is displayed --------------------------------------------------------------

    def refresh(self) -> None:
        """Bring displayed points up to the newest preview; call it before drawing."""
        self._stale = False
        if self.editing is not None:
            for body in self.model.bodies:
                if body.visible:
                    self.editing.follow(self._displays[body.key].in_hand)

    def surface(self, key: str) -> DisplaySurface:
        """What to draw of a body: polygons, lines, markers, node numbers, the proxy."""
        return self._displays[key].surface

    def points(self, key: str) -> Array:
        """(m, 3) displayed points of a body now, one for each of `surface(key).nodes`.

        While a drag is under way and the surface has a proxy, they stay behind: show
        `proxy_points`.
        """
        shown = self._displays[key]
        after_walls = self.model.body(key).follows == Way.WALLS
        if after_walls and self.editing is None and shown.volume is not None:
            return shown.volume.points[shown.surface.nodes]
        return shown.full.positions

    def proxy_points(self, key: str) -> Array:
        """(k, 3) points of the proxy now, one for each of `surface(key).proxy.rows`."""
        proxy = self._displays[key].proxy
        if proxy is None:
            raise InputError("this surface needs no proxy")
        return proxy.positions

    def inside(self, key: str) -> NDArray[np.bool_] | None:
        """(m,) displayed points of a body inside the active lattice; None until known."""
        active = self.model.active
        return None if active is None else self._displays[key].full.inside(active)

    def nodes(self, key: str) -> Follower:
        """All nodes of a body and what they are bound to; workers may ask it."""
        return self._displays[key].nodes

    def volume(self, key: str) -> DeformedVolume | None:
        """All nodes of a body as deformed, inverted cells counted; None until known."""
        return self._displays[key].volume

    def checking(self, key: str) -> bool:
        """Whether `volume(key)` is being worked out."""
        return self._displays[key].checking

    def check(self) -> None:
        """Have the volumes worked out that nobody works on: the user has cancelled that."""
        self._displays.start_work()

    # ---- files --------------------------------------------------------------------------

    def open_mesh(self, path: PathLike) -> None:
        """Read a mesh and add it as a body."""
        filing.open_mesh(self, path)

    def export_mesh(self, key: str, path: PathLike) -> None:
        """Write a body as it is deformed."""
        filing.export_mesh(self, key, path)

    def import_lattice(self, path: PathLike, block: str | None = None) -> None:
        """Read a lattice file and add it."""
        filing.import_lattice(self, path, block)

    def export_lattice(self, key: str, path: PathLike) -> None:
        """Write a lattice, at rest and as it is."""
        filing.export_lattice(self, key, path)

    def open(self, path: PathLike) -> None:
        """Read a project, which replaces everything."""
        filing.open_project(self, path)

    def save(self, path: PathLike | None = None, pack_meshes: bool | None = None) -> None:
        """Write the project; by default to where it came from, meshes in it or not as before."""
        target = self.path if path is None else path
        if target is None:
            raise InputError("the project has no file yet")
        if pack_meshes is not None:
            self._packs = pack_meshes
        filing.save(self, target, self._packs)

    def recover(self, left: Left) -> None:
        """Read the autosave of a session that died (see `recovery`); it counts as not saved."""
        filing.open_project(self, left.autosave, left)

    # ---- keeping up ---------------------------------------------------------------------

    def _follow(self, model: Model) -> None:
        self._displays.take(model)

    def _put_back(self) -> None:
        self._displays.put_back(self.model)

    def _start_work(self) -> None:
        self._displays.start_work()
