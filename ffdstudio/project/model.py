"""What the user is working on, as one immutable value.

1. A `Model` is never changed: a command makes another one that shares all that stays the
   same. Undo is then the model before, the same object and so the same bytes.
2. Bodies and lattices are known by a key that never changes (``body1``, ``lattice2``); the
   name is what the user sees. Keys are given in order, so that a replay gives the same.
3. Several lattices compose in the order of the tree: the second one deforms what the first
   one has left, as functions do. Its rest lies around that shape. A lattice that is not
   deformed passes every coordinate on bit for bit, and so does each one for points outside.
4. Hidden lattices deform all the same; a lattice that is switched off (`enabled`) does not.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Self, TypeVar

from ffdstudio.engine import Lattice
from ffdstudio.engine.context import LatticeContext
from ffdstudio.errors import InputError
from ffdstudio.meshes.ways import Way

if TYPE_CHECKING:
    from ffdstudio.meshes import Mesh
    from ffdstudio.optimize.spec.study import StudySpec

Index = tuple[int, ...]
Item = TypeVar("Item", "Body", "LatticeItem", "Body | LatticeItem")
NO_SHAPES: Mapping[str, Lattice] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Body:
    """A mesh in the scene.

    Attributes
    ----------
    key, name : str
    mesh : Mesh
        As it was read; never changed.
    path : pathlib.Path
        Absolute path of the mesh.
    sha256 : str
        Hash of the mesh's files when it was read; empty when unknown.
    packed : dict of str to bytes, or None
        The mesh's files when they travel inside the project.
    visible : bool
    colour : str or None
        ``#rrggbb``, or None for the theme's choice.
    hidden_markers : frozenset of str
    boxes : str
        What becomes of FFD boxes in its file when it is exported: "update", "strip" or "keep".
    follows : str
        "lattice": the lattices carry all nodes; "walls": they move the walls, and the volume
        follows them.
    """

    key: str
    name: str
    mesh: Mesh
    path: Path
    sha256: str = ""
    packed: dict[str, bytes] | None = None
    visible: bool = True
    colour: str | None = None
    hidden_markers: frozenset[str] = frozenset()
    boxes: str = "update"
    follows: str = Way.LATTICE


@dataclass(frozen=True, eq=False, kw_only=True)
class LatticeItem(LatticeContext):
    """A lattice in the scene: a `LatticeContext`, and what the scene knows of it.

    Attributes
    ----------
    key : str
    visible, enabled : bool
        Whether it is drawn; whether it deforms.
    shapes : mapping of str to Lattice
        Saved shapes by name, in the space of `rest`.
    coarser : Lattice or None
        The rest before the latest refinement: embeddings in it carry over. Not stored.
    """

    key: str
    visible: bool = True
    enabled: bool = True
    shapes: Mapping[str, Lattice] = field(default_factory=lambda: NO_SHAPES)
    coarser: Lattice | None = None


@dataclass(frozen=True, eq=False)
class StudyItem:
    """A study of the document; its records are kept beside the model.

    Attributes
    ----------
    key, name : str
    spec : StudySpec
        What it does; bodies and lattices of the document by their keys in angle brackets.
    """

    key: str
    name: str
    spec: StudySpec


@dataclass(frozen=True, eq=False)
class Model:
    """All bodies, lattices and studies; and which lattice is being edited (`active`, a key)."""

    bodies: tuple[Body, ...] = ()
    lattices: tuple[LatticeItem, ...] = ()
    studies: tuple[StudyItem, ...] = ()
    active: str | None = None
    used: int = 0  # number in the latest key; keys are never given twice

    def body(self, key: str) -> Body:
        """Body of that key; `InputError` if there is none."""
        return _find(self.bodies, key, "body")

    def lattice(self, key: str) -> LatticeItem:
        """Lattice of that key; `InputError` if there is none."""
        return _find(self.lattices, key, "lattice")

    def item(self, key: str) -> Body | LatticeItem:
        """Body or lattice of that key."""
        every: tuple[Body | LatticeItem, ...] = self.items
        return _find(every, key, "body or lattice")

    def study(self, key: str) -> StudyItem:
        """Study of that key; `InputError` if there is none."""
        for item in self.studies:
            if item.key == key:
                return item
        raise InputError(f"there is no study {key}")

    @property
    def items(self) -> tuple[Body | LatticeItem, ...]:
        """Bodies, then lattices."""
        return *self.bodies, *self.lattices

    @property
    def active_lattice(self) -> LatticeItem | None:
        """The lattice being edited."""
        return None if self.active is None else self.lattice(self.active)

    @property
    def steps(self) -> tuple[LatticeItem, ...]:
        """Lattices that deform, in the order in which they compose."""
        return tuple(item for item in self.lattices if item.enabled)

    def new_key(self, kind: str) -> str:
        """Key for the next body or lattice."""
        return f"{kind}{self.used + 1}"

    def free_name(self, wanted: str) -> str:
        """Return the wanted name, or the first of ``wanted 2``, ``wanted 3``, ... that is free."""
        names = {item.name for item in (*self.items, *self.studies)}
        number, name = 1, wanted
        while name in names:
            number += 1
            name = f"{wanted} {number}"
        return name

    # ---- other models -----------------------------------------------------------------

    def with_(self, *items: Body | LatticeItem) -> Self:
        """Model with the items in place of those of the same key."""
        new = {item.key: item for item in items}
        bodies = tuple(new.get(body.key, body) for body in self.bodies)
        lattices = tuple(new.get(item.key, item) for item in self.lattices)
        return replace(self, bodies=bodies, lattices=lattices)  # type: ignore[arg-type]

    def plus(self, item: Body | LatticeItem) -> Self:
        """Model with one more body or lattice; a new lattice becomes the active one."""
        self.check_name(item.name)
        if item.key in {old.key for old in self.items}:
            raise InputError(f"there is a {item.key} already")
        if isinstance(item, Body):
            return replace(self, bodies=(*self.bodies, item), used=self.used + 1)
        lattices = (*self.lattices, item)
        return replace(self, lattices=lattices, active=item.key, used=self.used + 1)

    def without(self, key: str) -> Self:
        """Model without a body or lattice."""
        self.item(key)
        bodies = tuple(body for body in self.bodies if body.key != key)
        lattices = tuple(item for item in self.lattices if item.key != key)
        active = self.active
        if active == key:
            active = lattices[-1].key if lattices else None
        return replace(self, bodies=bodies, lattices=lattices, active=active)

    def check_name(self, name: str, own: str = "") -> None:
        """Raise `InputError` if a name is empty or taken by another item than `own`."""
        if not isinstance(name, str) or not name.strip():
            raise InputError("a name needs at least one letter")
        every = (*self.items, *self.studies)
        if any(item.name == name and item.key != own for item in every):
            raise InputError(f"the name {name} is taken")


def _find(items: Iterable[Item], key: str, kind: str) -> Item:
    for item in items:
        if item.key == key:
            return item
    raise InputError(f"there is no {kind} {key}")
