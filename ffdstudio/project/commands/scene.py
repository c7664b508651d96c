"""Commands that change what is there: bodies and lattices."""

# ruff: noqa: D102 - apply and label are documented once, in Command

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from ffdstudio.engine import Lattice
from ffdstudio.engine.frozen import frozen_mask
from ffdstudio.errors import InputError
from ffdstudio.exchange.morphed import BOXES
from ffdstudio.meshes.ways import Way
from ffdstudio.project.commands.base import Command, Numbers, Points
from ffdstudio.project.model import Body, Index, LatticeItem, Model

if TYPE_CHECKING:
    from ffdstudio.meshes import Mesh


@dataclass(frozen=True)
class OpenMesh(Command):
    """Add a body. `mesh` is what was read from `path`; the journal keeps path and hash."""

    verb: ClassVar[str] = "open mesh"
    path: str
    sha256: str = ""
    name: str = "body"
    visible: bool = True
    colour: str | None = None
    hidden_markers: tuple[str, ...] = ()
    boxes: str = "update"
    follows: str = Way.LATTICE
    mesh: Mesh | None = field(default=None, compare=False, repr=False)
    packed: dict[str, bytes] | None = field(default=None, compare=False, repr=False)

    def apply(self, model: Model) -> Model:
        if self.mesh is None:
            raise InputError(f"the mesh {self.path} has not been read yet")
        return model.plus(
            Body(
                key=model.new_key("body"),
                name=model.free_name(self.name),
                mesh=self.mesh,
                path=Path(self.path),
                packed=self.packed,
                sha256=self.sha256,
                visible=self.visible,
                colour=self.colour,
                hidden_markers=frozenset(self.hidden_markers),
                boxes=_checked(self.boxes),
                follows=_way(self.follows),
            )
        )

    def label(self, model: Model) -> str:
        return f"Open {self.name}"


@dataclass(frozen=True)
class CreateBox(Command):
    """Add a box lattice; the parameters are those of `Lattice.box`."""

    verb: ClassVar[str] = "create box"
    name: str
    lower: Numbers
    upper: Numbers
    shape: Index
    degrees: Index
    axes: Points | None = None
    spacing: str = "greville"
    frozen: int = 0
    open_faces: tuple[Index, ...] = ()

    @property
    def lattice(self) -> Lattice:
        """The box at rest."""
        box = Lattice.box(self.lower, self.upper, self.shape, self.degrees, self.axes, self.spacing)
        frozen_mask(box.shape, self.frozen, self.open_faces)
        return box

    def apply(self, model: Model) -> Model:
        box = self.lattice
        key, name = model.new_key("lattice"), model.free_name(self.name)
        faces = self.open_faces
        return model.plus(LatticeItem(box, box, self.frozen, faces, name, key=key))

    def label(self, model: Model) -> str:
        return f"Create {self.name} " + "×".join(str(n) for n in self.shape)


@dataclass(frozen=True)
class Refit(Command):
    """Lay an undeformed box lattice anew: other bounds, counts, degrees; nothing deforms."""

    verb: ClassVar[str] = "refit box"
    item: str
    box: CreateBox

    def apply(self, model: Model) -> Model:
        item = model.lattice(self.item)
        if item.deformed:
            raise InputError(f"{item.name} is deformed; reset it before fitting it anew")
        if item.shapes:
            raise InputError(f"{item.name} has saved shapes, which another box would not fit")
        box = self.box.lattice
        frozen, faces = self.box.frozen, self.box.open_faces
        new = replace(item, rest=box, current=box, frozen=frozen, open_faces=faces)
        return model.with_(new)

    def label(self, model: Model) -> str:
        return f"Fit {model.lattice(self.item).name} anew"


@dataclass(frozen=True, eq=False)
class AddLattice(Command):
    """Add a lattice as it is: from a file, or of a project that is opened."""

    verb: ClassVar[str] = "add lattice"
    name: str
    rest: Lattice
    current: Lattice
    frozen: int = 0
    visible: bool = True
    enabled: bool = True
    shapes: tuple[tuple[str, Lattice], ...] = ()
    open_faces: tuple[Index, ...] = ()

    def apply(self, model: Model) -> Model:
        for lattice in (self.current, *dict(self.shapes).values()):
            if not lattice.same_space(self.rest) or lattice.shape != self.rest.shape:
                raise InputError(f"the states of lattice {self.name} have different knots")
        key, name = model.new_key("lattice"), model.free_name(self.name)
        same = self.current == self.rest  # one object, so that undeformed is seen at once
        current = self.rest if same else self.current
        item = LatticeItem(
            self.rest, current, self.frozen, self.open_faces, name, key=key,
            visible=self.visible, enabled=self.enabled, shapes=dict(self.shapes),
        )  # fmt: skip
        return model.plus(item)

    def label(self, model: Model) -> str:
        return f"Add {self.name}"


@dataclass(frozen=True)
class Remove(Command):
    """Remove a body or a lattice."""

    verb: ClassVar[str] = "remove"
    item: str

    def apply(self, model: Model) -> Model:
        return model.without(self.item)

    def label(self, model: Model) -> str:
        return f"Remove {model.item(self.item).name}"


@dataclass(frozen=True)
class Rename(Command):
    """Rename a body or a lattice."""

    verb: ClassVar[str] = "rename"
    looks_only = True
    item: str
    name: str

    def apply(self, model: Model) -> Model:
        model.check_name(self.name, self.item)
        return model.with_(replace(model.item(self.item), name=self.name))

    def label(self, model: Model) -> str:
        return f"Rename {model.item(self.item).name} to {self.name}"


@dataclass(frozen=True)
class Show(Command):
    """Show or hide bodies and lattices."""

    verb: ClassVar[str] = "show"
    looks_only = True
    items: tuple[str, ...]
    visible: bool = True

    def apply(self, model: Model) -> Model:
        return model.with_(*(replace(model.item(k), visible=self.visible) for k in self.items))

    def label(self, model: Model) -> str:
        names = ", ".join(model.item(key).name for key in self.items)
        return f"{'Show' if self.visible else 'Hide'} {names}"


@dataclass(frozen=True)
class Isolate(Command):
    """Show one body alone; lattices stay as they are."""

    verb: ClassVar[str] = "isolate"
    looks_only = True
    item: str

    def apply(self, model: Model) -> Model:
        model.body(self.item)
        return model.with_(*(replace(b, visible=b.key == self.item) for b in model.bodies))

    def label(self, model: Model) -> str:
        return f"Isolate {model.body(self.item).name}"


@dataclass(frozen=True)
class ShowMarkers(Command):
    """Show or hide markers of a body."""

    verb: ClassVar[str] = "show markers"
    looks_only = True
    item: str
    markers: tuple[str, ...]
    visible: bool = True

    def apply(self, model: Model) -> Model:
        body, chosen = model.body(self.item), frozenset(self.markers)
        unknown = chosen - set(body.mesh.markers)
        if unknown:
            raise InputError(f"{body.name} has no marker {min(unknown)}")
        hidden = body.hidden_markers - chosen if self.visible else body.hidden_markers | chosen
        return model.with_(replace(body, hidden_markers=hidden))

    def label(self, model: Model) -> str:
        return f"{'Show' if self.visible else 'Hide'} {', '.join(self.markers)}"


@dataclass(frozen=True)
class TreatBoxes(Command):
    """Choose what becomes of FFD boxes in a body's file on export: update, strip or keep."""

    verb: ClassVar[str] = "treat boxes"
    looks_only = True
    item: str
    boxes: str

    def apply(self, model: Model) -> Model:
        return model.with_(replace(model.body(self.item), boxes=_checked(self.boxes)))

    def label(self, model: Model) -> str:
        return f"{self.boxes.capitalize()} FFD boxes of {model.body(self.item).name}"


@dataclass(frozen=True)
class Follow(Command):
    """Choose how a body follows: carried by the lattices, or its volume after its walls."""

    verb: ClassVar[str] = "follow"
    item: str
    follows: str

    def apply(self, model: Model) -> Model:
        return model.with_(replace(model.body(self.item), follows=_way(self.follows)))

    def label(self, model: Model) -> str:
        name = model.body(self.item).name
        walls = self.follows == Way.WALLS
        return f"{name} follows its walls" if walls else f"{name} is carried by the lattice"


@dataclass(frozen=True)
class Colour(Command):
    """Give a body a colour, ``#rrggbb``, or None for the theme's choice."""

    verb: ClassVar[str] = "colour"
    looks_only = True
    item: str
    colour: str | None

    def apply(self, model: Model) -> Model:
        return model.with_(replace(model.body(self.item), colour=self.colour))

    def label(self, model: Model) -> str:
        return f"Colour {model.body(self.item).name}"


@dataclass(frozen=True)
class Activate(Command):
    """Choose the lattice to edit."""

    verb: ClassVar[str] = "activate"
    item: str

    def apply(self, model: Model) -> Model:
        model.lattice(self.item)
        return replace(model, active=self.item)

    def label(self, model: Model) -> str:
        return f"Edit {model.lattice(self.item).name}"


@dataclass(frozen=True)
class Enable(Command):
    """Let a lattice deform, or not."""

    verb: ClassVar[str] = "enable"
    item: str
    enabled: bool = True

    def apply(self, model: Model) -> Model:
        return model.with_(replace(model.lattice(self.item), enabled=self.enabled))

    def label(self, model: Model) -> str:
        return f"Switch {model.lattice(self.item).name} {'on' if self.enabled else 'off'}"


def _checked(boxes: str) -> str:
    if boxes not in BOXES:
        raise InputError(f"FFD boxes can be {', '.join(BOXES)}, not {boxes}")
    return boxes


def _way(follows: str) -> Way:
    if follows not in set(Way):
        raise InputError(f"a body follows its {' or the '.join(Way)}, not {follows!r}")
    return Way(follows)
