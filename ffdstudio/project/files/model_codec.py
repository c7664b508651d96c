"""Between the model and what a project file holds."""

from __future__ import annotations

from typing import Any

from ffdstudio.engine import Lattice
from ffdstudio.project.commands import Activate, AddLattice, Command
from ffdstudio.project.files.records import BodyRecord, LatticeRecord, ProjectFile
from ffdstudio.project.files.study_codec import study_files
from ffdstudio.project.model import Body, LatticeItem, Model
from ffdstudio.project.study_records import StudyRecords

WINDOW = "window"  # the section of what only the window wants to know


def to_file(
    model: Model, sections: dict[str, Any], records: StudyRecords | None = None
) -> ProjectFile:
    """Return what to store of a model; other sections are kept as they are."""
    active = model.active_lattice
    kept = sections.get(WINDOW, {})
    kept = kept if isinstance(kept, dict) else {}
    window = {**kept, "active": None if active is None else active.name}
    return ProjectFile(
        [_body(body) for body in model.bodies],
        [_lattice(item) for item in model.lattices],
        {**sections, WINDOW: window},
        study_files(model, records or StudyRecords()),
    )


def _body(body: Body) -> BodyRecord:
    look = {
        "hidden_markers": sorted(body.hidden_markers),
        "boxes": body.boxes,
        "follows": str(body.follows),
    }
    stored = (body.path, body.visible, body.colour, body.sha256, body.packed, look)
    return BodyRecord(body.name, *stored)


def _lattice(item: LatticeItem) -> LatticeRecord:
    settings = {
        "visible": item.visible,
        "shapes": [[n, s] for n, s in item.shapes.items()],
        "open_faces": [list(face) for face in item.open_faces],
    }
    return LatticeRecord(item.name, item.rest, item.current, item.frozen, item.enabled, settings)


def lattice_commands(content: ProjectFile) -> list[Command]:
    """Return commands that add the stored lattices, in order."""
    return [_added(record) for record in content.lattices]


def _added(record: LatticeRecord) -> AddLattice:
    return AddLattice(
        record.name,
        record.rest,
        record.current,
        record.frozen,
        bool(record.settings.get("visible", True)),
        record.active,
        tuple(_shapes(record.settings.get("shapes", []))),
        tuple(_faces(record.settings.get("open_faces", []), record.rest.dimension)),
    )


def _shapes(stored: Any) -> list[tuple[str, Lattice]]:
    stored = stored if isinstance(stored, list) else []
    pairs = [item for item in stored if isinstance(item, list) and len(item) == 2]
    return [(str(name), shape) for name, shape in pairs if isinstance(shape, Lattice)]


def _faces(stored: Any, dimension: int) -> list[tuple[int, int]]:
    every = [(axis, side) for axis in range(dimension) for side in (0, 1)]
    return [face for face in every if list(face) in stored] if isinstance(stored, list) else []


def activation(content: ProjectFile, model: Model) -> list[Command]:
    """Return the command that makes the stored active lattice active, if there is one."""
    window = content.sections.get(WINDOW, {})
    name = window.get("active") if isinstance(window, dict) else None
    return [Activate(item.key) for item in model.lattices if item.name == name]
