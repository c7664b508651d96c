"""The gestures that change a lattice, as generators over the document fed with events.

1. Each begins an `Edit`, takes events until it ends, and commits or aborts: one drag, one
   entry in the history. `Tools` drives them.
2. Release, Return and loss of focus commit; Esc, the right button and ``cancel`` abort.
3. X, Y, Z lock to an axis, with Shift to the plane of the two others; the same again frees.
   What is flat stays in its plane: a lock that leads out of it is none. Numbers that are typed
   take the place of the mouse (`typed_numbers`).
4. If somebody else ends the edit (an action, undo), the gesture is over.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.project.checks.motion_guard import Motion
from ffdstudio.project.edit import Edit
from ffdstudio.project.interaction.dragging import Lock, displacement, snap_step
from ffdstudio.project.interaction.events import PointerEvent
from ffdstudio.project.interaction.feedback import OCTAVE, Feedback, vector_text
from ffdstudio.project.interaction.flatness import within
from ffdstudio.project.interaction.skin import SkinPoint, handle_of
from ffdstudio.project.interaction.spread import Soft
from ffdstudio.project.interaction.transforms import rotation, scaling
from ffdstudio.project.interaction.typed_numbers import Typed, is_typing

if TYPE_CHECKING:
    from ffdstudio.project.interaction.tools import Tools

Gesture = Generator[None, PointerEvent, None]
LIGHTEST, HEAVIEST = 1e-3, 1e3
ANGLE_STEP, SCALE_STEP, WEIGHT_STEP = 5.0, 0.1, 0.1
WHEEL = 1.1
TURN_STEP = 4.0  # degrees on which the guard takes nodes to move straight


@dataclass(frozen=True)
class Path:
    """A turn or a scaling as a path: what makes it the same one, how far, and what is there.

    `at` gives a transform of (n, 3) points and the read-out.
    """

    key: tuple[object, ...]
    asked: float
    at: Callable[[float], tuple[Callable[[Array], Array], str]]
    step: float = np.inf


@dataclass
class Stroke:
    """A gesture under way: the event it began with, the latest one, the lock."""

    tools: Tools
    edit: Edit
    press: PointerEvent
    last: PointerEvent
    lock: Lock | None = None
    typed: Typed | None = None
    fields: int = 1  # numbers that can be typed

    def run(self, update: Callable[[], Feedback], wheel: Callable[[float], None]) -> Gesture:
        """Update after each event until the gesture ends."""
        self.edit.guarded = True
        try:
            while self.tools.document.editing is self.edit:
                self.tools.show(update())
                event = yield
                if _aborts(event):
                    self.edit.abort()
                elif _commits(event):
                    self.edit.commit()
                elif event.kind == "wheel":
                    wheel(event.steps)
                else:
                    self.take(event)
        except BaseException:
            self.edit.abort()
            raise

    def take(self, event: PointerEvent) -> None:
        """Take note of where the cursor is, of modifiers, of keys that lock, and of numbers."""
        if event.kind == "key" and is_typing(event.key):
            if self.typed is not None or event.key not in ("Tab", "Backspace"):
                before = self.typed or Typed.fields(self.fields)
                typed = before.took(event.key)
                self.typed = None if typed.empty else typed
        elif event.kind == "key" and event.key in ("X", "Y", "Z"):
            number, plane = "XYZ".index(event.key), self.tools.plane
            wanted = within(Lock.without(number) if event.shift else Lock.axis(number), plane)
            if wanted is not None:
                self.lock = plane if self.lock == wanted else wanted
        elif event.kind == "move":
            self.last = event
        elif event.kind == "key":  # Shift or Ctrl went down or up
            self.last = replace(self.last, shift=event.shift, ctrl=event.ctrl)


def _aborts(event: PointerEvent) -> bool:
    right = event.happened("press", "right")
    return right or event.happened("key", "Escape") or event.kind == "cancel"


def _commits(event: PointerEvent) -> bool:
    left = event.happened("release", "left")
    return left or event.happened("key", "Return") or event.kind == "lost"


def _no_wheel(steps: float) -> None:
    """Take no notice."""


# ---- moving, turning, scaling -----------------------------------------------------------


def move(tools: Tools, press: PointerEvent, event: PointerEvent, anchor: Array) -> Gesture:
    """Drag the selected points, and what goes with them, by the one at `anchor`."""
    spread, edit = tools.begin()
    stroke = Stroke(tools, edit, press, event, tools.plane, fields=3)
    soft = tools.options.soft

    def update() -> Feedback:
        last = stroke.last
        step = snap_step(press.camera, anchor) if last.ctrl else 0.0
        way = (anchor, press.at, last.at, stroke.lock, last.shift, step)
        vector = displacement(press.camera, *way)
        if stroke.typed is not None:
            vector = _typed_vector(stroke.typed, stroke.lock)
        same = edit.along(vector) if spread.plain else None
        verdict = None if same is None else tools.judge(edit, same)
        if verdict is not None:
            vector = verdict.vector
            edit.translate(vector)
        else:
            moving = vector

            def there(share: float) -> Array:
                return spread.place(edit.start, lambda points: points + share * moving)

            key = ("move", *vector.tolist(), spread.points, tuple(spread.share.tolist()))
            motion = Motion(key, 1.0, lambda share: edit.lattice_with(there(share)))
            share, verdict = tools.judge_motion(motion)
            vector = share * vector
            edit.place(there(share))
        radius = 0.0 if soft is None else soft.radius
        text = vector_text(vector, stroke.lock)
        if stroke.typed is not None:
            text = f"{stroke.typed.text(('x', 'y', 'z'))}   {text}"
        return Feedback(text, last.at, None, anchor, stroke.lock, radius, verdict)

    def wheel(steps: float) -> None:
        nonlocal spread, soft
        if soft is not None:
            soft = Soft(soft.radius * WHEEL**steps, soft.profile)
            tools.options = replace(tools.options, soft=soft)
            spread = tools.spread(edit.item)

    yield from stroke.run(update, wheel)


def pull(tools: Tools, press: PointerEvent, event: PointerEvent, skin: SkinPoint) -> Gesture:
    """Drag a point of the skin; selected control points are held."""
    document = tools.document
    handle = handle_of(document, skin, document.selection)
    if handle is None:
        while event.kind not in ("release", "lost", "cancel"):
            tools.show(Feedback("no free control point moves the skin here", event.at))
            event = yield
        return
    edit = document.edit(handle.points)
    stroke = Stroke(tools, edit, press, event, tools.plane, fields=3)

    def update() -> Feedback:
        last = stroke.last
        step = snap_step(press.camera, skin.place) if last.ctrl else 0.0
        way = (skin.place, press.at, last.at, stroke.lock, last.shift, step)
        asked = displacement(press.camera, *way)
        if stroke.typed is not None:
            asked = _typed_vector(stroke.typed, stroke.lock)
        whole = handle.move(asked)
        key = ("skin", skin.body, skin.row, *asked.tolist())
        motion = Motion(key, 1.0, lambda share: edit.lattice_with(edit.start + share * whole))
        share, verdict = tools.judge_motion(motion)
        edit.place(edit.start + share * whole)
        text = f"skin {vector_text(share * asked, stroke.lock)}"
        if stroke.typed is not None:
            text = f"{stroke.typed.text(('x', 'y', 'z'))}   {text}"
        return Feedback(text, last.at, None, skin.place, stroke.lock, verdict=verdict)

    yield from stroke.run(update, _no_wheel)


def turn(tools: Tools, press: PointerEvent, event: PointerEvent, pivot: Array) -> Gesture:
    """Rotate the selected points about a pivot, round the view or a locked axis."""

    def transform(stroke: Stroke) -> Path:
        angle = _angle(press, stroke.last, pivot)
        axis = -press.camera.forward  # towards the viewer: anticlockwise as seen
        lock = tools.plane or stroke.lock  # what is flat turns in its plane only
        if lock is not None:
            along = np.array(lock.direction)
            axis, angle = along, angle if along @ axis >= 0 else -angle
        if stroke.last.shift:
            angle *= 0.1
        if stroke.last.ctrl:
            angle = round(angle / ANGLE_STEP) * ANGLE_STEP
        if stroke.typed is not None:
            angle = stroke.typed.values[0]
        key = ("turn", *axis.tolist())
        return Path(key, angle, lambda a: (rotation(axis, a, pivot), f"{a:.4g}°"), TURN_STEP)

    yield from _transformed(tools, press, event, pivot, transform)


def scale(tools: Tools, press: PointerEvent, event: PointerEvent, pivot: Array) -> Gesture:
    """Scale the selected points about a pivot, in all directions or as locked."""

    def transform(stroke: Stroke) -> Path:
        factor = _ratio(press, stroke.last, pivot)
        if stroke.last.shift:
            factor = 1 + 0.1 * (factor - 1)
        if stroke.last.ctrl:
            factor = round(factor / SCALE_STEP) * SCALE_STEP
        if stroke.typed is not None:
            factor = stroke.typed.values[0]
        chosen = np.ones(3)
        if stroke.lock is not None:
            along = np.abs(stroke.lock.direction) > 0.5
            chosen = (along != stroke.lock.plane).astype(float)

        def at(more: float) -> tuple[Callable[[Array], Array], str]:
            return scaling(1 + more * chosen, pivot), f"× {1 + more:.4g}"

        return Path(("scale", *chosen.tolist()), factor - 1, at)

    yield from _transformed(tools, press, event, pivot, transform)


def _transformed(
    tools: Tools,
    press: PointerEvent,
    event: PointerEvent,
    pivot: Array,
    transform: Callable[[Stroke], Path],
) -> Gesture:
    spread, edit = tools.begin()
    stroke = Stroke(tools, edit, press, event, tools.plane)

    def update() -> Feedback:
        path = transform(stroke)

        def there(place: float) -> Array:
            return spread.place(edit.start, path.at(place)[0])

        motion = Motion(
            path.key, path.asked, lambda place: edit.lattice_with(there(place)), path.step
        )
        place, verdict = tools.judge_motion(motion)
        edit.place(there(place))
        text = path.at(place)[1]
        if stroke.typed is not None:
            text = f"{stroke.typed.text(('',))}   {text}"
        return Feedback(text, stroke.last.at, None, pivot, stroke.lock, verdict=verdict)

    yield from stroke.run(update, _no_wheel)


def _arms(press: PointerEvent, last: PointerEvent, pivot: Array) -> tuple[Array, Array]:
    """From the pivot to where the drag began and to the cursor, pixels with y up."""
    centre = press.camera.project(pivot)[0]
    return (np.array(press.at) - centre) * [1, -1], (np.array(last.at) - centre) * [1, -1]


def _angle(press: PointerEvent, last: PointerEvent, pivot: Array) -> float:
    (ax, ay), (bx, by) = _arms(press, last, pivot)
    return float(np.degrees(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)))


def _ratio(press: PointerEvent, last: PointerEvent, pivot: Array) -> float:
    begin, now = _arms(press, last, pivot)
    return float(np.linalg.norm(now)) / max(float(np.linalg.norm(begin)), 1.0)


def _typed_vector(typed: Typed, lock: Lock | None) -> Array:
    """Displacement that is typed: along the axis that is locked, else by coordinates."""
    if lock is not None and not lock.plane:
        return typed.values[0] * np.array(lock.direction)
    vector = np.array(typed.values)
    if lock is not None:  # what is flat stays in its plane
        normal = np.array(lock.direction)
        vector = vector - (vector @ normal) * normal
    return vector


# ---- weights ----------------------------------------------------------------------------


def weigh(tools: Tools, press: PointerEvent, event: PointerEvent) -> Gesture:
    """Drag the handle of a weight: all selected weights are multiplied alike."""
    edit = tools.document.edit()
    stroke = Stroke(tools, edit, press, event)

    def update() -> Feedback:
        up = (press.y - stroke.last.y) * (0.1 if stroke.last.shift else 1.0)
        weights = edit.weights * 2.0 ** (up / OCTAVE)
        if stroke.last.ctrl:
            weights = np.maximum(np.round(weights / WEIGHT_STEP), 1) * WEIGHT_STEP
        if stroke.typed is not None:
            weights = np.full(len(weights), stroke.typed.values[0])
        asked = np.clip(weights, LIGHTEST, HEAVIEST)

        def there(share: float) -> Array:
            return np.asarray(edit.weights * (asked / edit.weights) ** share)

        key = ("weigh", *asked.tolist())
        motion = Motion(key, 1.0, lambda share: edit.lattice_with(weights=there(share)), 0.25)
        share, verdict = tools.judge_motion(motion)
        weights = there(share) if share < 1 else asked
        edit.weigh(weights)
        return Feedback(f"w {weights[0]:.4g}", stroke.last.at, verdict=verdict)

    yield from stroke.run(update, _no_wheel)
