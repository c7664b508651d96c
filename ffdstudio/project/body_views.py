"""Keeping what is displayed up with the model: at once where it can be, else by work.

1. Displayed points move at once if their embeddings are known; what is missing is embedded
   in a worker, and *moved* is emitted when that has arrived.
2. All nodes and the inverted cells of each body are worked out in a worker after each edit;
   only the newest result counts. Work that the user cancels is due again: it is started by
   the next edit, or by who needs it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ffdstudio.meshes.ways import Way
from ffdstudio.project.model import Body, Model
from ffdstudio.project.running import Progress
from ffdstudio.project.view.body_view import BodyView
from ffdstudio.project.view.surface import surface_of
from ffdstudio.project.view.volume import DeformedVolume, work_out

if TYPE_CHECKING:
    from ffdstudio.project.editor import Editor


class Displays:
    """The bodies of a document as they are displayed.

    The surface of a mesh is worked out by whoever read it, or here when it is first seen.
    """

    def __init__(self, document: Editor) -> None:
        self._document = document
        self._shown: dict[str, BodyView] = {}

    def __getitem__(self, key: str) -> BodyView:
        """Body of that key, as it is displayed."""
        return self._shown[key]

    def take(self, model: Model) -> None:
        """Follow a model: its bodies, and where its lattices move them as far as is known."""
        known, self._shown = self._shown, {}
        for body in model.bodies:
            shown = known.get(body.key)
            if shown is None or shown.mesh is not body.mesh:
                shown = self._first_seen(body)
            self._shown[body.key] = shown
            shown.settle(model.steps)
            shown.expect(body.follows, [(item.rest, item.current) for item in model.steps])

    def put_back(self, model: Model) -> None:
        """Take back what a drag has done to displayed points."""
        for shown in self._shown.values():
            shown.in_hand.settle(model.steps)

    def _first_seen(self, body: Body) -> BodyView:
        surfaces = self._document.surfaces
        if body.mesh not in surfaces:
            surfaces[body.mesh] = surface_of(body.mesh)
        return BodyView(body.mesh, surfaces[body.mesh])

    # ---- work -----------------------------------------------------------------------------

    def start_work(self) -> None:
        """Start what it takes for the rest to follow the document's model."""
        model = self._document.settled_model
        for body in model.bodies:
            shown = self._shown[body.key]
            if not shown.settled:
                self._start_embedding(body, shown, model)
            if shown.outdated:
                self._start_volume(body, shown, model)

    def _start_embedding(self, body: Body, shown: BodyView, model: Model) -> None:
        def work(progress: Progress) -> None:
            shown.embed(model.steps, progress)

        def done(_: None) -> None:
            if self._shown.get(body.key) is shown:
                self._embedded(shown)

        document = self._document
        failed = document.failed(f"{body.name} cannot be embedded")
        label, key = f"Embedding {body.name}", f"embed {body.key}"
        document.runner.start(label, work, done, failed, key)

    def _embedded(self, shown: BodyView) -> None:
        """Take embeddings that have arrived; a drag may be under way, or edits done since."""
        document = self._document
        shown.settle(document.settled_model.steps)
        if document.editing is not None:
            document.editing.forget(shown.in_hand)
            document.tell_moving()
        document.moved.emit()
        if not shown.settled:
            self.start_work()

    def _start_volume(self, body: Body, shown: BodyView, model: Model) -> None:
        document, state, by = self._document, shown.expected, shown.by
        shown.outdated, shown.checking = False, True
        document.volume_changed.emit(body.key)

        def end(volume: DeformedVolume | None, outdated: bool = False) -> None:
            if self._shown.get(body.key) is shown and shown.expected is state:
                shown.volume, shown.outdated, shown.checking = volume, outdated, False
                shown.by = shown.by if volume is None else volume.by
                document.volume_changed.emit(body.key)
                if body.follows == Way.WALLS and volume is not None:
                    document.tell_moving()  # inner nodes that are displayed

        def work(progress: Progress) -> DeformedVolume:
            return work_out(body, shown.nodes, model.steps, progress, by)

        def failed(error: Exception) -> None:
            end(None)
            document.failed(f"The cells of {body.name} cannot be checked")(error)

        document.runner.start(
            f"Deforming {body.name}",
            work,
            end,
            failed,
            f"volume {body.key}",
            cancelled=lambda: end(None, outdated=True),
        )
