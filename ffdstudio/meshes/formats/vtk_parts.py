"""VTK files that name others: blocks (.vtm) and pieces (.pvtu, .pvtp).

1. The parts are read by the readers of their own formats and joined; named blocks are markers.
2. Written, the parts go beside the file under the same relative names; no part is overwritten
   unless the file itself is.
"""

from __future__ import annotations

import re
import warnings
from itertools import pairwise
from pathlib import Path, PurePosixPath

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.files import read_bytes
from ffdstudio.meshes.formats import Progress, recognise
from ffdstudio.meshes.formats.deck_files import DeckFile, DeckTemplate
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning
from ffdstudio.meshes.topology import Cells

_TAG = re.compile(rb"<(/?)(Block|Piece|DataSet)\b([^<>]*?)(/?)>")
_ATTRIBUTE = re.compile(rb"([\w:]+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")
HEAD = 65536
MOST = 10_000  # parts of a file


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a file of parts; see `read_mesh`."""
    source = Source(path, data)
    found = _parts(source)
    if not found:
        raise source.failure("this file names no parts")
    files, meshes = [DeckFile(source, "")], []
    for k, (_, relative) in enumerate(found):
        own = path.parent / relative
        content = read_bytes(own)
        mesh: Mesh = recognise(own, content[:HEAD]).load().read(own, content, lambda fraction: None)
        files.append(DeckFile(Source(own, content), relative))
        meshes.append(mesh)
        progress((k + 1) / len(found))
    return _joined(source, files, meshes, [name for name, _ in found])


def _parts(source: Source) -> list[tuple[str, str]]:
    """Name and file of each part; the name is that of its block if it has none."""
    found: list[tuple[str, str]] = []
    blocks: list[str] = []
    for match in _TAG.finditer(source.data):
        attributes = {key: decoded(a or b) for key, a, b in _ATTRIBUTE.findall(match[3])}
        file = attributes.get(b"file") or attributes.get(b"Source")
        name = attributes.get(b"name", "")
        if file:
            inside = "/".join(part for part in (*blocks, name) if part)
            found.append((inside, _checked(source, match.start(), file)))
        elif match[2] == b"Block":
            if match[1]:
                del blocks[-1:]
            elif not match[4]:
                blocks.append(name)
    if len(found) > MOST:
        raise source.failure("it names too many parts")
    return found


def _checked(source: Source, place: int, file: str) -> str:
    """Name of a part that lies in the folder of the file."""
    relative = PurePosixPath(file.replace("\\", "/"))
    if relative.is_absolute() or ".." in relative.parts or ":" in file or not relative.parts:
        raise source.error(place, f"its part {file[:60]} lies outside its folder")
    return str(relative)


def _joined(source: Source, files: list[DeckFile], meshes: list[Mesh], names: list[str]) -> Mesh:
    first = np.cumsum([0, *(len(mesh.points) for mesh in meshes)]).tolist()
    cells: dict[str, list[Indices]] = {}
    markers: Markers = {}
    unread: dict[str, int] = {}
    for mesh, name, begin in zip(meshes, names, first, strict=False):
        own = {kind: nodes + begin for kind, nodes in mesh.cells.items()}
        for kind, nodes in own.items():
            cells.setdefault(kind, []).append(nodes)
        if name and own:
            markers[f"{name} ({begin})" if name in markers else name] = own
        for kind, count in mesh.unread.items():
            unread[kind] = unread.get(kind, 0) + count
    if any(mesh.faces is not None for mesh in meshes):
        raise source.failure("parts that are made of faces are not supported")
    points = np.concatenate([mesh.points for mesh in meshes])
    joined: Cells = {kind: np.concatenate(parts) for kind, parts in cells.items()}
    slices = [slice(a, b) for a, b in pairwise(first)]

    def contents(new: Array) -> list[bytes]:
        parts = zip(meshes, slices, strict=True)
        return [source.data, *(_patched(mesh, new[part]) for mesh, part in parts)]

    def warn(path: Path, new: Array) -> None:
        if np.array_equal(new, points):
            return
        singles = [m for m in meshes if getattr(m.template, "dtype", np.dtype("f8")).itemsize < 8]
        if singles:
            warnings.warn(
                f"{path.name}: parts of this file store single precision (float32); "
                "coordinates are rounded to it",
                MeshWarning,
                stacklevel=5,
            )

    template = DeckTemplate(source.path, points, files, contents, warn)
    return Mesh(points, joined, markers, unread=unread, template=template)


def _patched(mesh: Mesh, points: Array) -> bytes:
    """Content of a part with these coordinates."""
    content: bytes = mesh.template.patched(points)  # type: ignore[union-attr]
    return content
