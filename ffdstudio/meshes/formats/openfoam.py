"""OpenFOAM meshes: the folder ``polyMesh`` of a case.

1. A case folder opens, its ``.foam`` file, or a polyMesh folder. The mesh is faces with the
   cells on both sides; patches become markers, their types the markers' kinds. So do zones of
   cells and faces.
2. Only ``points`` changes. Written elsewhere, the other files of the mesh are copied byte for
   byte; nothing else of a case is.
3. A folder that holds another mesh is refused: several files cannot be replaced at once, and
   a crash between two of them would leave a mixture.
4. A decomposed case has a mesh in every ``processorN``: these do not follow, which is said.
"""

from __future__ import annotations

import gzip
import hashlib
import warnings
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes, remove, write_bytes, write_together
from ffdstudio.meshes.compressed import packed
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.foamfile import FoamFile, dictionary
from ffdstudio.meshes.formats.foamzones import add_zones
from ffdstudio.meshes.formats.number_table import pick_numbers
from ffdstudio.meshes.formats.patch import BinaryTemplate, TextTemplate, warn_if_rounded
from ffdstudio.meshes.mesh import Faces, Markers, Mesh, MeshWarning, boundary_faces
from ffdstudio.paths import is_same

KINDS = {
    "symmetryPlane": "symmetry",
    "cyclic": "periodic",
    "cyclicAMI": "periodic",
    "cyclicACMI": "periodic",
}
COPIED = ("boundary", "faces", "owner", "neighbour", "cellZones", "faceZones", "pointZones")
TOPOLOGY = ("faces", "owner", "neighbour")


def folder_of(path: Path) -> Path:
    """Folder polyMesh that a path stands for: a case, its .foam file or the folder itself."""
    if path.suffix.lower() in (".foam", ".openfoam"):
        path = path.parent
    if path.name == "polyMesh":
        return path
    if path.parent.name == "polyMesh":  # one of its files
        return path.parent
    if path.name == "constant":
        return path / "polyMesh"
    return path / "constant" / "polyMesh"


@dataclass(frozen=True, eq=False)
class FoamTemplate:
    """A polyMesh folder with the content of its file of points."""

    folder: Path
    file: FoamFile
    points: TextTemplate | BinaryTemplate
    digests: dict[str, str]  # of the other files of the mesh, as they were read
    kept: dict[str, bytes] | None = None  # their content, where the folder goes away

    @property
    def original(self) -> Array:
        """(n, 3) coordinates as in the file."""
        return self.points.original

    def write(self, path: Path, points: Array) -> None:
        """Write the file of points, and copies of the mesh's other files if it is elsewhere."""
        warn_if_rounded(self.original, points, self.dtype, path)
        target, files = folder_of(path), self._as_read()
        new = self.points.patched(points)
        if self.file.source.path.suffix == ".gz":
            new = self.file.raw if new == self.file.source.data else packed(new)
        try:
            target.mkdir(parents=True, exist_ok=True)
            if path.suffix.lower() in (".foam", ".openfoam") and not path.exists():
                write_bytes(path, b"")
        except OSError as error:
            raise InputError(f"cannot write {target}: {error.strerror}") from error
        copies = {} if is_same(target, self.folder) else self._copies(target, files)
        file = target / self.file.source.path.name
        write_together([*copies.items(), (file, new)])
        _remove_twin(file)
        if list(target.parent.parent.glob("processor*")):
            warnings.warn(
                f"{path.name}: the case is decomposed; the meshes in its processor folders "
                "do not follow, decompose it again",
                MeshWarning,
                stacklevel=3,
            )

    @property
    def dtype(self) -> np.dtype:
        """Type of the coordinates in the file."""
        return self.points.dtype

    def _copies(self, target: Path, files: dict[str, bytes]) -> dict[Path, bytes]:
        """Files of the mesh, besides its points, that are not in a folder yet."""
        found = {}
        for name, data in files.items():
            plain = name.removesuffix(".gz")
            if plain in TOPOLOGY:
                _refuse_another(target, plain, data)
            copy = target / name
            if not copy.exists() or read_bytes(copy, to_update=True) != data:
                found[copy] = data
        return found

    def _as_read(self) -> dict[str, bytes]:
        """The mesh's other files; raises if one is not what was read with these points."""
        files = self.kept if self.kept is not None else contents(self.folder)
        for name, digest in self.digests.items():
            if name not in files or _digest(files[name]) != digest:
                raise InputError(
                    f"{self.folder / name}: has changed since the mesh was read; open it again"
                )
        return {name: files[name] for name in self.digests}


def contents(folder: Path) -> dict[str, bytes]:
    """Files of a mesh besides its points, packed or not, by name."""
    files = [folder / f"{name}{end}" for name in COPIED for end in ("", ".gz")]
    return {file.name: read_bytes(file) for file in files if file.is_file()}


def without_folder(mesh: Mesh) -> Mesh:
    """Return a mesh of a folder that will go away: what it needs of it stays in memory."""
    template = mesh.template
    if not isinstance(template, FoamTemplate):
        return mesh
    return replace(mesh, template=replace(template, kept=contents(template.folder)))


def _digests(folder: Path, topology: tuple[FoamFile, ...]) -> dict[str, str]:
    """SHA-256 of a mesh's files besides its points: of what was read, not of what is there now."""
    known = {file.source.path.name: file.raw for file in topology}
    twins = {f"{name}.gz" for name in known} | {name.removesuffix(".gz") for name in known}
    more = {name: data for name, data in contents(folder).items() if name not in twins}
    return {name: _digest(data) for name, data in (more | known).items()}


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _refuse_another(target: Path, name: str, data: bytes) -> None:
    """Raise if a folder has a file of that name with other content, packed or not."""
    for file in (target / name, target / f"{name}.gz"):
        if file.exists() and _plain(read_bytes(file, to_update=True)) != _plain(data):
            raise InputError(f"{target} holds another mesh ({name}): choose another folder")


def _plain(data: bytes) -> bytes:
    try:
        return gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data
    except (OSError, EOFError, zlib.error):  # damaged: not the same in any case
        return data


@dataclass(frozen=True, eq=False)
class Patch:
    """A patch as its file states it.

    Attributes
    ----------
    name, type : str
    nodes : numpy.ndarray
        (k,) in OpenFOAM's order: as the patch's faces first meet them.
    """

    name: str
    type: str
    nodes: Indices


def patches_of(mesh: Mesh) -> list[Patch]:
    """Patches of an OpenFOAM mesh with their nodes in OpenFOAM's order.

    Raises
    ------
    InputError
        If the mesh was not read from an OpenFOAM case.
    """
    template, faces = mesh.template, mesh.faces
    if not isinstance(template, FoamTemplate) or faces is None:
        raise InputError(f"{mesh.path or 'the mesh'} is not one of OpenFOAM")
    found = []
    for name, kind, begin, end in _stated(template.folder, faces):
        nodes = faces.nodes[faces.offsets[begin] : faces.offsets[end]]
        distinct, first = np.unique(nodes, return_index=True)
        found.append(Patch(name, kind, distinct[np.argsort(first)]))
    return found


def _remove_twin(file: Path) -> None:
    """Remove the packed form of a file, or the plain one, which is no longer true."""
    twin = file.with_suffix("") if file.suffix == ".gz" else file.with_name(f"{file.name}.gz")
    remove(twin)


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read the mesh of a case; see `read_mesh`."""
    folder = folder_of(path)
    if not folder.is_dir():
        raise InputError(_not_there(path, folder))
    _warn_of_others(path, folder)
    points = FoamFile.find(folder, "points")
    coordinates = _points(points)
    progress(0.3)
    nodes_of, owners, others = (FoamFile.find(folder, name) for name in TOPOLOGY)
    nodes, offsets = nodes_of.faces()
    progress(0.7)
    owner, neighbour = owners.labels(), others.labels()
    template = FoamTemplate(
        folder, points, coordinates, _digests(folder, (nodes_of, owners, others))
    )
    faces = _faces(folder, len(template.original), nodes, offsets, owner, neighbour)
    markers, kinds, partners = _patches(folder, faces)
    add_zones(folder, faces, len(template.original), markers)
    return Mesh(
        template.original,
        {},
        markers,
        faces=faces,
        kinds=kinds,
        partners=partners,
        template=template,
    )


def _not_there(path: Path, folder: Path) -> str:
    base = path if path.is_dir() else path.parent
    if list(base.glob("processor*")):
        return (
            f"{path}: this case is decomposed; reconstruct its mesh, "
            "or open the folder processorN/constant/polyMesh"
        )
    regions = _regions(folder.parent)
    if regions:
        listed = " or ".join(str(region) for region in regions)
        return f"{path}: this case has a mesh in each region: open {listed}"
    return f"{path}: there is no folder {folder}"


def _regions(constant: Path) -> list[Path]:
    """Meshes of the regions of a case."""
    return sorted(found for found in constant.glob("*/polyMesh") if found.is_dir())


def _warn_of_others(path: Path, folder: Path) -> None:
    """Tell of points in time folders, and of regions, which are not what is opened."""
    case = folder.parent.parent
    newer = [found.parent.parent.name for found in case.glob("[0-9]*/polyMesh/points*")]
    if newer and folder.parent.name == "constant":
        warnings.warn(
            f"{path.name}: other points of the mesh lie in the time folders "
            f"{', '.join(sorted(newer))}; those in constant are opened",
            MeshWarning,
            stacklevel=3,
        )
    regions = _regions(folder.parent) if folder.parent.name == "constant" else []
    if regions:
        warnings.warn(
            f"{path.name}: the regions {', '.join(r.parent.name for r in regions)} have meshes of "
            "their own, which are not opened",
            MeshWarning,
            stacklevel=3,
        )


def _points(file: FoamFile) -> TextTemplate | BinaryTemplate:
    count, begin = file.list_at(file.begin)
    if file.is_binary:
        raw = file.binary(3 * count, begin, file.scalar).astype(np.float64).reshape(-1, 3)
        bad = np.flatnonzero(~np.isfinite(raw).all(axis=1))
        if len(bad):
            raise file.source.failure(f"point {bad[0]} (counted from 0) is not finite")
        places = begin + file.scalar.itemsize * np.arange(3 * count).reshape(-1, 3)
        return BinaryTemplate(file.source.data, raw, file.scalar, places)
    starts, ends = file.spans(begin)
    if len(starts) != 3 * count:
        raise file.source.failure(
            f"{count} points are announced, found {len(starts)} coordinates instead of {3 * count}"
        )
    points = pick_numbers(file.source, starts, ends).reshape(-1, 3)
    return TextTemplate(file.source.data, points, starts.reshape(-1, 3), ends.reshape(-1, 3))


def _faces(
    folder: Path, count: int, nodes: Indices, offsets: Indices, owner: Indices, other: Indices
) -> Faces:
    total = len(offsets) - 1
    if len(owner) != total or len(other) > total:
        raise InputError(
            f"{folder}: {total} faces, but {len(owner)} owners and {len(other)} neighbours"
        )
    if nodes.size and not (nodes.min() >= 0 and nodes.max() < count):
        raise InputError(f"{folder}: a face refers to a point that is not in 0 to {count - 1}")
    neighbour = np.full(total, -1)
    neighbour[: len(other)] = other
    most = 4 * total  # every cell has four faces or more
    if (owner < 0).any() or max(owner.max(initial=-1), neighbour.max(initial=-1)) > most:
        raise InputError(f"{folder}: a face belongs to a cell that cannot be there")
    return Faces(nodes, offsets, owner, np.maximum(neighbour, -1))


def _patches(folder: Path, faces: Faces) -> tuple[Markers, dict[str, str], dict[str, str]]:
    """Patches with their types and, of cyclic ones, their neighbours."""
    source = FoamFile.find(folder, "boundary").source
    markers: Markers = {}
    kinds, partners = {}, {}
    values_of = dict(dictionary(source))
    for name, kind, begin, end in _stated(folder, faces):
        markers[name] = boundary_faces(faces, np.arange(begin, end))
        kinds[name] = KINDS.get(kind, kind)
        if "neighbourPatch" in values_of[name]:
            partners[name] = values_of[name]["neighbourPatch"]
    return markers, kinds, partners


def _stated(folder: Path, faces: Faces) -> Iterator[tuple[str, str, int, int]]:
    """Name, type, first face and the one behind the last, of each patch."""
    source = FoamFile.find(folder, "boundary").source
    for name, values in dictionary(source):
        if "startFace" not in values:
            continue
        begin, count = (
            source.integer(values.get(key, "").encode("latin-1"), 0, f"{key} of patch {name}")
            for key in ("startFace", "nFaces")
        )
        if begin + count > len(faces):
            raise source.failure(f"patch {name} ends behind the last face")
        yield name, values.get("type", "patch"), begin, begin + count
