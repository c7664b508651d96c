"""A seeded user who does anything: the model stays consistent, undo leads back to every byte."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.files.replaying import export, replay
from ffdstudio.project.interaction import numeric_edits as typed
from ffdstudio.project.interaction import selection as s
from ffdstudio.project.interaction.events import PointerEvent
from ffdstudio.project.interaction.spread import PROFILES, Mirror, Soft
from ffdstudio.project.interaction.tools import Options, Tools
from ffdstudio.project.interaction.transforms import rotation, scaling
from ffdstudio.project.model import LatticeItem, Model
from tests.project.scenes import BOX, look, opened, write_cube

MOST = 400  # control points of a lattice: refinement stops there, for time


def digest(model: Model) -> str:
    """Hash of everything in a model but the meshes themselves."""
    total = hashlib.sha256()
    for body in model.bodies:
        said = (body.key, body.name, body.visible, body.colour, sorted(body.hidden_markers))
        total.update(repr(said).encode())
    for item in model.lattices:
        said = (item.key, item.name, item.frozen, item.visible, item.enabled, list(item.shapes))
        total.update(repr((said, item.rest.degrees, model.active)).encode())
        for lattice in (item.rest, item.current, *item.shapes.values()):
            for array in (*lattice.knots, lattice.control_points, lattice.weights, lattice.axes):
                total.update(array.tobytes())
    return total.hexdigest()


class User:
    """Acts at random on a document; what the document refuses with `InputError` is fine."""

    def __init__(self, document: Document, mesh: Path, seed: int) -> None:
        self.document, self.mesh = document, mesh
        self.tools = Tools(document)
        self.random = np.random.default_rng(seed)
        self.refused = 0
        self.actions = [getattr(self, name) for name in dir(User) if name.startswith("do_")]

    def act(self) -> None:
        try:
            self.actions[self.random.integers(len(self.actions))]()
        except InputError:
            self.refused += 1

    # ---- choices --------------------------------------------------------------------------

    def one(self, items):  # type: ignore[no-untyped-def]
        items = list(items)
        if not items:
            raise InputError("there is nothing to choose")
        return items[self.random.integers(len(items))]

    @property
    def item(self) -> LatticeItem:
        item = self.document.model.active_lattice
        if item is None:
            raise InputError("no lattice")
        return item

    def point(self) -> tuple[int, ...]:
        return tuple(int(self.random.integers(n)) for n in self.item.rest.shape)

    def vector(self, size: float = 0.1) -> tuple[float, ...]:
        return tuple((size * self.random.normal(size=3)).tolist())

    # ---- actions --------------------------------------------------------------------------

    def do_gesture(self) -> None:
        mode = self.one(["move", "move", "rotate", "scale", "box"])
        soft = Soft(0.4, self.one(PROFILES)) if self.random.random() < 0.2 else None
        mirror = Mirror(0, 0.5) if self.random.random() < 0.2 else None
        self.tools.options = Options(mode, soft, mirror, self.one(["centroid", "picked"]))
        eye = tuple((self.random.normal(size=3) * 4 + 0.5).tolist())
        camera = look(eye, parallel=bool(self.random.integers(2)))
        at = camera.project(self.item.current.control_points[self.point()])[0]
        if np.isfinite(at).all():
            self.gesture(camera, at)

    def gesture(self, camera, at: np.ndarray) -> None:  # type: ignore[no-untyped-def]
        def send(kind: str, place: np.ndarray, **rest: object) -> None:
            self.tools.handle(PointerEvent(kind, camera, *map(float, place), **rest))  # type: ignore[arg-type]

        def sometimes() -> bool:
            return bool(self.random.random() < 0.2)

        send("press", at, button="left", shift=sometimes())
        for _ in range(self.random.integers(6)):
            at = at + self.random.normal(size=2) * 30
            send("move", at, shift=sometimes(), ctrl=sometimes())
            if sometimes():
                send("key", at, key=self.one("XYZ"), shift=sometimes())
            if sometimes():
                send("wheel", at, steps=1.0)
            if sometimes():
                self.document.refresh()
        end = self.one(["release", "release", "release", "Escape", "lost", "undo", "right"])
        if end == "undo":
            self.document.undo()
        elif end == "Escape":
            send("key", at, key="Escape")
        elif end == "right":
            send("press", at, button="right")
        elif end == "lost":
            send("lost", at)
        send("release", at, button="left")
        assert not self.tools.busy
        assert self.document.editing is None

    def do_nudge(self) -> None:
        key = self.one(["Left", "Right", "Up", "Down"])
        self.tools.handle(PointerEvent("key", look(), key=key))

    def do_select(self) -> None:
        shape, chosen = self.item.rest.shape, frozenset({self.point(), self.point()})
        grown = self.one([
            chosen, s.grow(chosen, shape), s.row(chosen, shape, 0), s.plane(chosen, shape, 1),
            s.everything(shape), s.NOTHING, s.inverse(chosen, shape),
        ])  # fmt: skip
        self.document.select(grown)

    def do_type(self) -> None:
        self.one([
            lambda: typed.set_position(self.document, (None, 0.3, None)),
            lambda: typed.set_displacement(self.document, self.vector()),
            lambda: typed.set_displacement(self.document, self.vector(), absolute=False),
            lambda: typed.set_weight(self.document, float(self.random.uniform(-0.1, 4))),
            lambda: typed.set_weight(self.document, 1.5, relative=True),
            lambda: typed.transform(self.document, rotation([0, 0, 1], 10, [0.5, 0.5, 0.5])),
            lambda: typed.transform(self.document, scaling([1.1, 1, 1], [0.5, 0.5, 0.5])),
        ])()  # fmt: skip

    def do_box(self) -> None:
        if len(self.document.model.lattices) < 3:
            low, high = self.random.uniform(-0.2, 0.3, 3), self.random.uniform(0.6, 1.2, 3)
            shape = tuple(int(n) for n in self.random.integers(2, 6, 3))
            degrees = tuple(min(3, n - 1) for n in shape)
            corners = tuple(low.tolist()), tuple(high.tolist())
            self.document.do(c.CreateBox("Box", *corners, shape, degrees))

    def do_refine(self) -> None:
        if self.item.rest.weights.size < MOST:
            axis, key = int(self.random.integers(3)), self.item.key
            low, high = self.item.rest.domain[axis]
            knot = float(low + (high - low) * self.one([0.25, 0.5, 0.7, 1.5]))
            self.document.do(self.one([
                c.InsertKnots(key, axis, (knot,)),
                c.ElevateDegree(key, axis),
                c.RemoveKnots(key, axis, (knot,), 0.05),
            ]))  # fmt: skip

    def do_net(self) -> None:
        key = self.item.key
        self.document.do(self.one([
            c.ResetPoints(key),
            c.ResetPoints(key, (self.point(), self.point())),
            c.FreezeLayers(key, int(self.random.integers(3))),
            c.MovePoints(key, (self.point(),), (self.vector(0.7),)),
            c.SetWeights(key, (self.point(),), (float(self.random.uniform(0.2, 5)),)),
        ]))  # fmt: skip

    def do_shape(self) -> None:
        key, name = self.item.key, self.one("abc")
        factors = tuple((n, float(self.random.normal())) for n in self.item.shapes)
        self.document.do(self.one([
            c.SaveShape(key, name), c.RemoveShape(key, name), c.BlendShapes(key, factors),
        ]))  # fmt: skip

    def do_scene(self) -> None:
        model = self.document.model
        item, lattice = self.one(model.items).key, self.one(model.lattices).key
        self.document.do(self.one([
            c.Rename(item, self.one(["wing", "tail", "box", "Box"])),
            c.Show((item,), bool(self.random.integers(2))),
            c.Isolate(item),
            c.IsolateMarker(item, "low"),
            c.ShowAll(),
            c.Colour(item, "#00ff00"),
            c.ShowMarkers(item, ("low",), bool(self.random.integers(2))),
            c.Activate(lattice),
            c.Enable(lattice, bool(self.random.integers(2))),
        ]))  # fmt: skip

    def do_remove(self) -> None:
        if self.random.random() < 0.3:
            self.document.do(c.Remove(self.one(self.document.model.items).key))

    def do_open(self) -> None:
        if len(self.document.model.bodies) < 2:
            self.document.open_mesh(self.mesh)

    def do_history(self) -> None:
        document = self.document
        count = len(document.history.entries)
        self.one([
            document.undo,
            document.redo,
            lambda: document.jump(max(0, document.history.position - 3)),
            lambda: document.jump(int(self.random.integers(count + 1))),
        ])() if self.random.random() < 0.5 else document.undo()  # fmt: skip


def check(document: Document) -> None:
    """Everything in the document fits together."""
    model = document.model
    keys = [item.key for item in model.items]
    assert len(set(keys)) == len(keys)
    assert len({item.name for item in model.items}) == len(keys)
    assert (model.active is None) == (not model.lattices)
    active = model.active_lattice
    shape = () if active is None else active.rest.shape
    assert document.selection <= s.everything(shape)
    for item in model.lattices:
        assert item.rest.same_space(item.current)
        frozen = item.frozen_mask
        rest, current = item.rest.control_points, item.current.control_points
        assert np.array_equal(rest[frozen], current[frozen])
    for body in model.bodies:
        points = document.points(body.key)
        assert points.shape == (len(document.surface(body.key).nodes), 3)
        assert np.isfinite(points).all()
        assert document.volume(body.key) is not None


class Witness:
    """Remembers each state by its entry in the history and compares when it comes again."""

    def __init__(self, document: Document, exact: bool = True) -> None:
        self.document, self.exact = document, exact  # displays lag behind where workers work
        self.seen: dict[int, tuple[object, str, list[np.ndarray]]] = {}
        self.history, self.compared = document.history, 0
        document.history_changed.connect(self.look)

    def look(self) -> None:
        history, model = self.document.history, self.document.settled_model
        if history is not self.history:  # another project
            self.history, self.seen = history, {}
        entry = history.entries[history.position - 1] if history.position else None
        points = [self.document.points(body.key) for body in model.bodies]
        old = self.seen.get(history.position)
        if old is None or old[0] is not entry:
            self.seen[history.position] = (entry, digest(model), points)
            return
        assert digest(model) == old[1]
        for now, then in zip(points, old[2], strict=True):  # embeddings may be made anew
            assert not self.exact or np.abs(now - then).max() < 1e-10
        self.compared += 1


def campaign(tmp_path: Path, actions: int, seed: int) -> None:
    """Act, go all the way back and forth, and replay the journal."""
    mesh = write_cube(tmp_path / "cube.su2")
    document = opened(mesh)
    witness = Witness(document)
    document.do(BOX)
    user = User(document, mesh, seed)
    for _ in range(actions):
        user.act()
        check(document)
    last = document.history.position
    for position in [*range(last, -1, -1), *range(last + 1)]:
        document.jump(position)
    assert witness.compared > last
    assert user.refused < actions / 2
    document.journal.save(tmp_path / "session.jsonl")
    model = replay(tmp_path / "session.jsonl")
    assert digest(model) == digest(document.model)
    written = export(model, tmp_path / "out")
    for each, body in zip(written, document.model.bodies, strict=True):
        document.export_mesh(body.key, tmp_path / "window.su2")
        assert each.path.read_bytes() == (tmp_path / "window.su2").read_bytes()


@pytest.mark.parametrize("seed", [1, 2])
def test_a_short_random_session_undoes_and_replays_to_the_same_bytes(
    tmp_path: Path, seed: int
) -> None:
    campaign(tmp_path, 100, seed)


@pytest.mark.campaign
def test_two_thousand_random_actions_undo_and_replay_to_the_same_bytes(tmp_path: Path) -> None:
    campaign(tmp_path, 2000, seed=2026)
