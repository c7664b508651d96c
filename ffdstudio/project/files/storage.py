"""The project file ``*.ffdproj``: one zip with a JSON manifest and NumPy arrays.

1. Nothing in it is ever executed or unpickled, and every size is checked (`archive`,
   `encoding`).
2. A file of a newer schema is refused; sections this version does not know are kept.
3. Meshes are references (`references`): one that is missing or has changed is reported and
   the rest of the project still opens.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
from pathlib import Path
from typing import Any

from ffdstudio.containers import archive
from ffdstudio.containers.strictjson import check_version, field, loads
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, write_bytes
from ffdstudio.project.files import references
from ffdstudio.project.files.encoding import decode, encode
from ffdstudio.project.files.records import BodyRecord, LatticeRecord, ProjectFile
from ffdstudio.project.files.study_codec import SECTION as STUDIES
from ffdstudio.project.files.study_codec import section_of, studies_of
from ffdstudio.version import __version__

FORMAT, SCHEMA = "ffdstudio-project", 1
MANIFEST = "manifest.json"
MOST_PARTS = 200_000  # lists and objects in the manifest; numbers are in arrays


def write_project(
    path: str | os.PathLike[str], content: ProjectFile, pack_meshes: bool = False
) -> None:
    """Write a project file, atomically.

    Parameters
    ----------
    path : path-like
        The ``*.ffdproj`` file.
    content : ProjectFile
        Its bodies get their `sha256` if they have none, and with `pack_meshes` their `packed`
        files.
    pack_meshes : bool
        Whether the meshes travel inside the file.

    Raises
    ------
    InputError
        If the file cannot be written, or a mesh to be packed cannot be read. A mesh that is
        only referred to may be missing; its last known hash is kept.
    """
    folder = Path(os.path.realpath(path)).parent
    entries: dict[str, bytes] = {}
    manifest = {
        "format": FORMAT,
        "schema": SCHEMA,
        "program": f"ffdstudio {__version__}",
        "bodies": [_body_out(b, folder, pack_meshes, entries) for b in content.bodies],
        "lattices": [_lattice_out(record, entries) for record in content.lattices],
        "sections": encode(_sections(content), entries),
    }
    text = json.dumps(manifest, indent=1, ensure_ascii=False, allow_nan=False)
    write_bytes(path, archive.pack({MANIFEST: text.encode(), **entries}))


def read_project(path: str | os.PathLike[str]) -> ProjectFile:
    """Read a project file; what is wrong with its meshes is listed in `problems`.

    Raises
    ------
    InputError
        If it cannot be read, is damaged or was written by a newer version.
    """
    name = os.fspath(path)
    entries = archive.unpack(read_bytes(path), name)
    if MANIFEST not in entries:
        raise InputError(f"{name}: no project file (it has no {MANIFEST})")
    manifest = loads(entries[MANIFEST], name, MOST_PARTS)
    _check_schema(manifest, name)
    folder = Path(os.path.realpath(path)).parent
    content = ProjectFile(
        [_body_in(item, folder, entries, name) for item in _objects(manifest, "bodies", name)],
        [_lattice_in(item, entries, name) for item in _objects(manifest, "lattices", name)],
        decode(field(manifest, "sections", dict, name), entries, name),
    )
    if isinstance(content.sections.get(STUDIES), list):
        content.studies = studies_of(content.sections.pop(STUDIES))
    found = (references.problem_with(body) for body in content.bodies)
    content.problems = [problem for problem in found if problem]
    return content


def _sections(content: ProjectFile) -> dict[str, Any]:
    return content.sections | ({STUDIES: section_of(content)} if content.studies else {})


def _check_schema(manifest: dict[str, Any], name: str) -> None:
    if manifest.get("format") != FORMAT:
        raise InputError(f"{name}: no project file of FFD Studio")
    check_version(manifest, "schema", SCHEMA, name)


def _objects(manifest: dict[str, Any], key: str, name: str) -> list[dict[str, Any]]:
    items = field(manifest, key, list, name)
    if not all(isinstance(item, dict) for item in items):
        raise InputError(f'{name}: "{key}" must be a list of objects')
    names = [field(item, "name", str, name) for item in items]
    if len(set(names)) < len(names):
        raise InputError(f'{name}: two of its "{key}" have the same name')
    result: list[dict[str, Any]] = items
    return result


def _body_out(
    body: BodyRecord, folder: Path, pack: bool, entries: dict[str, bytes]
) -> dict[str, Any]:
    if pack:
        body.packed = references.contents(body)
        body.sha256 = references.fingerprint(body.packed)
    elif not body.sha256:  # once known, a save need not read the mesh again
        with contextlib.suppress(InputError):
            body.sha256 = references.fingerprint(references.contents(body))
    return {
        "name": body.name,
        "path": references.relative(body.path, folder),
        "sha256": body.sha256,
        "visible": body.visible,
        "colour": body.colour,
        "packed": None if body.packed is None else _packed_out(body.packed, entries),
        "settings": encode(body.settings, entries),
    }


def _packed_out(files: dict[str, bytes], entries: dict[str, bytes]) -> list[str]:
    number = len({name.split("/")[1] for name in entries if name.startswith("meshes/")})
    names = [f"meshes/{number}/{name}" for name in files]
    entries.update(zip(names, files.values(), strict=True))
    return names


def _body_in(
    item: dict[str, Any], folder: Path, entries: dict[str, bytes], name: str
) -> BodyRecord:
    colour = field(item, "colour", (str, type(None)), name)
    if colour is not None and not re.fullmatch("#[0-9a-fA-F]{6}", colour):
        raise InputError(f"{name}: {colour!r} is no colour")
    packed = field(item, "packed", (list, type(None)), name)
    return BodyRecord(
        field(item, "name", str, name),
        references.absolute(field(item, "path", str, name), folder),
        field(item, "visible", bool, name),
        colour,
        field(item, "sha256", str, name),
        None if packed is None else _packed_in(packed, entries, name),
        decode(field(item, "settings", dict, name), entries, name),
    )


def _packed_in(names: list[Any], entries: dict[str, bytes], name: str) -> dict[str, bytes]:
    files = {}
    for entry in names:
        if not isinstance(entry, str) or entry.count("/") < 2 or entry not in entries:
            raise InputError(f"{name}: the packed mesh {entry!r} is missing")
        files[entry.split("/", 2)[2]] = entries[entry]
    if not files:
        raise InputError(f"{name}: a packed mesh has no files")
    return files


def _lattice_out(record: LatticeRecord, entries: dict[str, bytes]) -> dict[str, Any]:
    return {
        "name": record.name,
        "rest": encode(record.rest, entries),
        "current": encode(record.current, entries),
        "frozen": record.frozen,
        "active": record.active,
        "settings": encode(record.settings, entries),
    }


def _lattice_in(item: dict[str, Any], entries: dict[str, bytes], name: str) -> LatticeRecord:
    rest, current = (decode(field(item, k, dict, name), entries, name) for k in ("rest", "current"))
    label = field(item, "name", str, name)
    both = isinstance(rest, Lattice) and isinstance(current, Lattice)
    if not (both and rest.same_space(current)):
        raise InputError(f'{name}: the lattice "{label}" and its deformed form do not fit together')
    frozen = field(item, "frozen", int, name)
    if frozen < 0:
        raise InputError(f'{name}: the lattice "{label}" cannot have {frozen} frozen layers')
    return LatticeRecord(
        label,
        rest,
        current,
        frozen,
        field(item, "active", bool, name),
        decode(field(item, "settings", dict, name), entries, name),
    )
