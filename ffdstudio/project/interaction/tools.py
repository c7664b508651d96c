"""Mouse and keys over the viewport: which gesture begins, and who gets the events.

The window makes a `PointerEvent` of everything and hands it to `Tools.handle`; what that
does not take is the camera's. Nothing here knows a window, so every gesture is tested by
replaying events.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from psygnal import Signal

from ffdstudio.aliases import Array
from ffdstudio.project.checks.guarding import DragGuard, Verdict
from ffdstudio.project.checks.motion_guard import Motion, MotionGuard
from ffdstudio.project.document import Document
from ffdstudio.project.edit import Edit
from ffdstudio.project.interaction import gestures, selection
from ffdstudio.project.interaction.dragging import Lock, snap_step
from ffdstudio.project.interaction.events import PointerEvent
from ffdstudio.project.interaction.feedback import NOTHING, Feedback, weight_handle
from ffdstudio.project.interaction.flatness import normal_axis, plane_of
from ffdstudio.project.interaction.occlusion import Occluders
from ffdstudio.project.interaction.picking import in_rectangle, near, nearest
from ffdstudio.project.interaction.skin import SkinPoint, skin_under
from ffdstudio.project.interaction.spread import Mirror, Soft, Spread
from ffdstudio.project.model import Index, LatticeItem

RADIUS = 10.0  # pixels around a control point or handle that count as on it
STILL = 3.0  # pixels that a click may move
FROZEN = "frozen: this point stays (Lattice panel, Frozen layers)"
ARROWS = {
    "Left": (-1, 0),
    "Right": (1, 0),
    "Up": (0, 1),
    "Down": (0, -1),
}


@dataclass(frozen=True)
class Options:
    """How tools work.

    Attributes
    ----------
    mode : str
        What a drag of a point does: ``move``, ``rotate`` or ``scale``; ``box`` selects,
        ``skin`` drags points of the mesh.
    soft : Soft or None
        Soft selection; its radius changes with the wheel during a drag.
    mirror : Mirror or None
        Mirror editing.
    pivot : str
        About what to rotate and scale: ``centroid`` of the selection, or the point
        ``picked`` last.
    """

    mode: str = "move"
    soft: Soft | None = None
    mirror: Mirror | None = None
    pivot: str = "centroid"


class Tools:
    """Takes events and changes the document.

    Attributes
    ----------
    document : Document
    options : Options
        Replace it to change how tools work.
    feedback : Feedback
        What to draw over the viewport; `changed()` is emitted when it changes.
    picked : tuple of int or None
        Control point that was clicked last.
    """

    changed = Signal()

    def __init__(self, document: Document, options: Options | None = None) -> None:
        self.document = document
        self.options = Options() if options is None else options
        self.occluders = Occluders(document)
        self.feedback = NOTHING
        self.picked: Index | None = None
        self._gesture: gestures.Gesture | None = None
        self._latest: PointerEvent | None = None
        self._advancing = False
        self._warden: DragGuard | None = None
        self._motions: MotionGuard | None = None

    @property
    def busy(self) -> bool:
        """Whether a gesture is under way; it then takes every event."""
        return self._gesture is not None

    def handle(self, event: PointerEvent) -> bool:
        """Take an event; False if it is none of the tools' business."""
        self._latest = event
        if self._gesture is None:
            self._gesture = self._beginning(event)
            if self._gesture is None:
                return event.kind == "key" and self._nudge(event)
        self._advance(event)
        return True

    def _advance(self, event: PointerEvent) -> None:
        assert self._gesture is not None
        self._advancing = True
        try:
            self._gesture.send(event)
        except StopIteration:
            self._over()
        except BaseException:
            self._over()
            raise
        finally:
            self._advancing = False

    def _over(self) -> None:
        self._gesture = None
        self.show(NOTHING)

    def cancel(self) -> None:
        """Abort what is under way."""
        if self._gesture is not None:
            self._gesture.close()
            self._over()

    def show(self, feedback: Feedback) -> None:
        """Show what a gesture has to say."""
        self.feedback = feedback
        self.changed.emit()

    # ---- the guard ------------------------------------------------------------------------

    def guard_with(self, warden: DragGuard) -> None:
        """Ask a warden about every drag by a vector."""
        self._warden = warden
        self._motions = MotionGuard(self.document, warden)
        self.document.guard = self._motions
        warden.ready.connect(self._again)

    def judge(self, edit: Edit, vector: Array) -> Verdict:
        """What the warden says of a drag; without one, to carry it out."""
        if self._warden is None:
            return Verdict(vector, vector)
        return self._warden.judge(edit.points, vector)

    def judge_motion(self, motion: Motion) -> tuple[float, Verdict | None]:
        """How far along its path a motion may go, and what is to be said of it."""
        if self._motions is None:
            return motion.asked, None
        return self._motions.judge(motion)

    def _again(self) -> None:
        """Update the drag under way: a guard has arrived."""
        if self._gesture is not None and self._latest is not None and not self._advancing:
            self._advance(replace(self._latest, kind="again"))

    # ---- what is under the cursor ---------------------------------------------------------

    def hit(self, event: PointerEvent) -> Index | None:
        """Control point of the active lattice under the cursor.

        A free one that is seen, else a free one behind a surface, else a frozen one.
        """
        item = self._item
        if item is None or not item.visible:
            return None
        flat, free = item.current.control_points.reshape(-1, 3), ~item.frozen_mask.ravel()
        under = np.flatnonzero(near(event.camera, flat, event.x, event.y, RADIUS))
        hidden = np.zeros(len(flat), dtype=bool)
        hidden[under] = self.occluders.hidden(event.camera, flat[under])
        for rows in (under[free[under] & ~hidden[under]], under[free[under]], under):
            row = nearest(event.camera, flat[rows], event.x, event.y, RADIUS)
            if row is not None:
                return _index(int(rows[row]), item)
        return None

    def handle_point(self) -> Index | None:
        """Control point that shows the handle of its weight: the one selected, or picked."""
        item, chosen = self._item, self.document.selection
        if item is None or not item.visible or not chosen:
            return None
        point = next(iter(chosen)) if len(chosen) == 1 else self.picked
        free = point is not None and point in chosen and not item.frozen_mask[point]
        return point if free else None

    def _on_handle(self, event: PointerEvent) -> bool:
        point, item = self.handle_point(), self._item
        if point is None or item is None:
            return False
        place, weight = item.current.control_points[point], item.current.weights[point]
        x, y = weight_handle(event.camera, place, float(weight))
        return bool(np.hypot(event.x - x, event.y - y) <= RADIUS)

    @property
    def _item(self) -> LatticeItem | None:
        return self.document.model.active_lattice

    # ---- for gestures ---------------------------------------------------------------------

    @property
    def plane(self) -> Lock | None:
        """Plane that flat things stay in: of a lattice of two directions, or of 2D meshes."""
        return plane_of(self.document.model)

    def spread(self, item: LatticeItem) -> Spread:
        """What moves with the selection, in the active lattice as it was at some time."""
        options = self.options
        return Spread(item, self.document.selection, options.soft, options.mirror)

    def begin(self) -> tuple[Spread, Edit]:
        """Begin an edit of what moves with the selection."""
        assert self._item is not None
        spread = self.spread(self._item)
        return spread, self.document.edit(spread.points)

    def pivot(self) -> Array:
        """(3,) point about which the selection is turned and scaled."""
        assert self._item is not None
        net, chosen = self._item.current.control_points, self.document.selection
        if self.options.pivot == "picked" and self.picked in chosen:
            return np.array(net[self.picked])
        where = tuple(np.array(sorted(chosen)).T)
        return np.array(net[where].mean(axis=0))

    # ---- beginnings -----------------------------------------------------------------------

    def _beginning(self, event: PointerEvent) -> gestures.Gesture | None:
        """Gesture that an event begins, ready to be sent that event; None for none."""
        if not event.happened("press", "left") or event.alt:
            return None
        if self.options.mode == "box" and self._item is not None:
            return _primed(self._band())
        if self.options.mode == "skin" and self._item is not None:
            at = event.camera, event.x, event.y
            skin = skin_under(self.document, self.occluders, *at)
            return None if skin is None else _primed(self._skin(skin))
        if self._on_handle(event):
            return _primed(self._weight())
        return _primed(self._grab()) if self.hit(event) is not None else None

    def _band(self) -> gestures.Gesture:
        press = yield
        while True:
            event = yield
            if event.kind in ("lost", "cancel") or event.happened("key", "Escape"):
                return
            if event.kind in ("move", "release"):
                self.show(Feedback(at=event.at, band=(*press.at, *event.at)))
            if event.happened("release", "left"):
                self._take_band(press, event)
                return

    def _take_band(self, press: PointerEvent, event: PointerEvent) -> None:
        item = self._item
        assert item is not None
        flat = item.current.control_points.reshape(-1, 3)
        rows = in_rectangle(event.camera, flat, press.at, event.at)
        inside = [_index(int(row), item) for row in rows]
        old = self.document.selection
        self.document.select(selection.band(old, inside, event.shift, event.ctrl))

    def _skin(self, skin: SkinPoint) -> gestures.Gesture:
        press = yield
        event = yield
        while _still(press, event):
            if event.kind in ("release", "lost", "cancel") or event.happened("key", "Escape"):
                return
            event = yield
        yield from gestures.pull(self, press, event, skin)

    def _weight(self) -> gestures.Gesture:
        press = yield
        event = yield
        yield from gestures.weigh(self, press, event)

    def _grab(self) -> gestures.Gesture:
        """Click or drag of a control point."""
        press = yield
        point, before = self.hit(press), self.document.selection
        assert point is not None
        self.picked = point
        if press.shift or point not in before:
            self.document.select(selection.click(before, point, press.shift))
        event = yield
        while _still(press, event):
            if event.kind in ("release", "lost", "cancel") or event.happened("key", "Escape"):
                if event.kind == "release" and not press.shift:
                    self.document.select(selection.click(before, point))
                return
            event = yield
        if self._item is not None and self._item.frozen_mask[point]:
            yield from self._stuck(event)
        elif point in self.document.selection and self._movable():
            yield from self._dragged(press, event, point)

    def _stuck(self, event: PointerEvent) -> gestures.Gesture:
        """Say at the cursor why nothing moves, until the button is let go."""
        while event.kind not in ("release", "lost", "cancel"):
            if event.happened("key", "Escape"):
                return
            self.show(Feedback(FROZEN, event.at))
            event = yield

    def _dragged(self, press: PointerEvent, event: PointerEvent, point: Index) -> gestures.Gesture:
        assert self._item is not None
        if self.options.mode == "rotate":
            return gestures.turn(self, press, event, self.pivot())
        if self.options.mode == "scale":
            return gestures.scale(self, press, event, self.pivot())
        anchor = np.array(self._item.current.control_points[point])
        return gestures.move(self, press, event, anchor)

    def _movable(self) -> bool:
        return self._item is not None and bool(self.spread(self._item).points)

    # ---- arrow keys -----------------------------------------------------------------------

    def _nudge(self, event: PointerEvent) -> bool:
        """Move the selection by a step of the grid along the axis most like the arrow."""
        if event.key not in ARROWS or not self.document.selection or not self._movable():
            return False
        pivot = self.pivot()
        step = snap_step(event.camera, pivot) * (0.1 if event.shift else 1.0)
        out = normal_axis(self.plane)
        vector = step * _axis_like(event, pivot, ARROWS[event.key], out)
        spread, edit = self.begin()
        edit.place(spread.place(edit.start, lambda points: points + vector))
        edit.commit()
        return True


def _axis_like(event: PointerEvent, point: Array, arrow: tuple[int, int], but: int | None) -> Array:
    """Coordinate axis but one, with its sign, that points most in the direction of an arrow."""
    size = event.camera.pixel_size(point)
    ends = event.camera.project(np.vstack([point, point + size * np.eye(3)]))
    along = (ends[1:] - ends[0]) @ [arrow[0], -arrow[1]]
    if but is not None:
        along[but] = 0.0
    best = int(np.argmax(np.abs(along)))
    result: Array = float(np.sign(along[best])) * np.eye(3)[best]
    return result


def _index(row: int, item: LatticeItem) -> Index:
    return tuple(int(k) for k in np.unravel_index(row, item.rest.shape))


def _still(press: PointerEvent, event: PointerEvent) -> bool:
    """Whether this is still a click."""
    far = np.hypot(event.x - press.x, event.y - press.y) > STILL
    return not (event.kind == "move" and far)


def _primed(gesture: gestures.Gesture) -> gestures.Gesture:
    """Generator that waits for its first event."""
    next(gesture)
    return gesture
