"""Fluent meshes in HDF5 (.cas.h5, .msh.h5), the common fluids format.

1. Under ``/meshes/1`` lie zones of nodes with their coordinates, faces as lists of nodes with the
   cells on both sides, and a table of the zones of faces: numbers, names, types, shadows.
2. Coordinates change in place, or through h5py where they are compressed; all else is kept.

Source: the files themselves, and VTK's reader for what its attributes mean.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.cgns_nodes import HDF_ERRORS, is_inside, opened, values_of
from ffdstudio.meshes.formats.fluent_mesh import Partners, Side, mesh_of
from ffdstudio.meshes.formats.hdftemplate import DatasetPlace, HdfTemplate, Piece, template_of
from ffdstudio.meshes.formats.patch import BinaryTemplate
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.formats.vtkcells import offsets_of
from ffdstudio.meshes.mesh import Mesh

KINDS = {  # types of zones by Fluent's numbers, where a table has no other text for them
    2: "interior",
    3: "wall",
    4: "pressure-inlet",
    5: "pressure-outlet",
    7: "symmetry",
    8: "periodic",
    9: "pressure-far-field",
    10: "velocity-inlet",
    12: "periodic",
    20: "mass-flow-inlet",
    24: "interface",
    36: "outflow",
    37: "axis",
}


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a Fluent mesh in HDF5; see `read_mesh`."""
    source = Source(path, data)
    with opened(source) as file:
        try:
            return _Reader(source, _group(source, file, "meshes/1")).mesh(progress)
        except HDF_ERRORS as error:
            if isinstance(error, InputError):
                raise
            raise source.failure(f"damaged HDF5 file ({type(error).__name__})") from error


def _group(source: Source, group: Any, path: str) -> Any:
    """Group below another one, reached without links."""
    for name in path.split("/"):
        if name not in group or not is_inside(group, name):
            raise source.failure(f"there is no {path} in this file: no Fluent mesh?")
        group = group[name]
    return group


class _Reader:
    """What one mesh of a file holds."""

    def __init__(self, source: Source, group: Any) -> None:
        self.source, self.group = source, group
        self.dimension = int(np.ravel(group.attrs.get("dimension", 3))[0])
        if self.dimension not in (2, 3):
            raise source.failure(f"the dimension must be 2 or 3, not {self.dimension}")

    def mesh(self, progress: Progress) -> Mesh:
        template = self._template()
        progress(0.4)
        sides = self._sides(len(template.original))
        progress(0.8)
        names = {
            number: (KINDS.get(kind, ""), name) for number, kind, name in self._zones() if name
        }
        return mesh_of(self.source, template, sides, names, self._pairs(), self.dimension)

    def _values(self, path: str) -> Any:
        folder, _, name = path.rpartition("/")
        group = _group(self.source, self.group, folder)
        if name not in group or not is_inside(group, name):
            raise self.source.failure(f"there is no {path} in this file")
        return values_of(self.source, group[name], path)

    def _members(self, path: str) -> Iterator[tuple[int, str, Any]]:
        """Members of a group in the order of their first number: that number, name, member."""
        group = _group(self.source, self.group, path)
        found = []
        for name in group:
            if is_inside(group, name):
                first = group[name].attrs.get("minId")
                if first is not None:
                    found.append((int(np.ravel(first)[0]), name))
        return ((first, name, group[name]) for first, name in sorted(found))

    def _template(self) -> BinaryTemplate | HdfTemplate:
        parts: list[Array] = []
        pieces: list[Piece] = []
        count = 0
        for first, name, item in self._members("nodes/coords"):
            values = values_of(self.source, item, f"nodes/coords/{name}")
            if values.dtype.kind != "f" or values.size % self.dimension or first != count + 1:
                raise self.source.failure(f"the coordinates of zone {name} do not fit")
            offset = item.id.get_offset()
            place = DatasetPlace(item.name, -1 if offset is None else offset, item.dtype)
            with np.errstate(invalid="ignore"):
                parts.append(values.astype(np.float64).reshape(-1, self.dimension))
            flat = np.arange(values.size).reshape(-1, self.dimension)
            pieces.append(Piece((place,) * self.dimension, flat, count + np.arange(len(flat))))
            count += len(flat)
        if not count:
            raise self.source.failure("there are no nodes in this file")
        points = np.zeros((count, 3))
        points[:, : self.dimension] = np.concatenate(parts)
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(bad):
            raise self.source.failure(f"node {bad[0] + 1} has a coordinate that is not finite")
        return template_of(self.source, points, pieces)

    def _sides(self, nodes: int) -> list[Side]:
        flat, sizes = self._faces(nodes)
        offsets = offsets_of(sizes)
        cells = np.stack([self._cells("c0", len(sizes)), self._cells("c1", len(sizes))], axis=1)
        if len(cells) and ((cells < 0).any() or (cells == 0).all(axis=1).any()):
            raise self.source.failure("a face without cells")
        sides = []
        firsts, lasts, types = (self._table(key) for key in ("minId", "maxId", "zoneType"))
        numbers = self._table("id")
        if not len(firsts) == len(lasts) == len(types) == len(numbers):
            raise self.source.failure("the table of zones of faces is damaged")
        for k in np.argsort(firsts, kind="stable").tolist():
            begin, end = int(firsts[k]) - 1, int(lasts[k])
            if not 0 <= begin <= end <= len(sizes):
                raise self.source.failure(f"zone {numbers[k]} has faces that are not there")
            own = offsets[begin : end + 1]
            part = flat[own[0] : own[-1]]
            sides.append(
                Side(
                    int(numbers[k]), begin + 1, int(types[k]), part, own - own[0], cells[begin:end]
                )
            )
        return sides

    def _faces(self, nodes: int) -> tuple[Indices, Indices]:
        """Nodes of all faces, from 0, and the number in each."""
        flat, sizes = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
        for first, name, _ in self._members("faces/nodes"):
            if first != 1 + sum(map(len, sizes)):
                raise self.source.failure("the sections of faces do not follow each other")
            sizes.append(self._values(f"faces/nodes/{name}/nnodes").astype(np.int64).ravel())
            flat.append(self._values(f"faces/nodes/{name}/nodes").astype(np.int64).ravel() - 1)
        joined, counts = np.concatenate(flat), np.concatenate(sizes)
        if (counts < 1).any() or counts.sum() != len(joined):
            raise self.source.failure("the sizes of the faces do not add up")
        if joined.size and not (joined.min() >= 0 and joined.max() < nodes):
            raise self.source.failure(f"a face refers to a node that is not in 1 to {nodes}")
        return joined, counts

    def _cells(self, key: str, faces: int) -> Indices:
        """Cell on one side of each face, from 1; 0 where a section leaves a face out."""
        found = np.zeros(faces, dtype=np.int64)
        for first, name, item in self._members(f"faces/{key}"):
            values = values_of(self.source, item, f"faces/{key}/{name}").astype(np.int64).ravel()
            if first < 1 or first - 1 + len(values) > faces:
                raise self.source.failure(f"faces/{key} does not fit the faces")
            found[first - 1 : first - 1 + len(values)] = values
        return found

    def _table(self, key: str) -> Indices:
        values: Indices = self._values(f"faces/zoneTopology/{key}").astype(np.int64).ravel()
        return values

    def _zones(self) -> Iterator[tuple[int, int, str]]:
        """Number, type and name of each zone of faces."""
        group = _group(self.source, self.group, "faces/zoneTopology")
        names: list[str] = []
        if "name" in group and is_inside(group, "name"):
            raw = np.ravel(self._values("faces/zoneTopology/name"))
            words = [decoded(w) if isinstance(w, bytes) else str(w) for w in raw]
            names = ";".join(words).strip("\0").split(";")
        numbers, types = self._table("id").tolist(), self._table("zoneType").tolist()
        names += [""] * (len(numbers) - len(names))
        return zip(numbers, types, names[: len(numbers)], strict=True)

    def _pairs(self) -> list[Partners]:
        """Periodic zones with the shadows that the table names."""
        group = _group(self.source, self.group, "faces/zoneTopology")
        if "shadowZoneId" not in group:
            return []
        none = np.empty((0, 2), dtype=np.int64)
        keys = ("id", "zoneType", "shadowZoneId")
        rows = zip(*map(self._table, keys), strict=False)
        return [Partners(int(n), int(s), none) for n, kind, s in rows if s > 0 and kind == 12]
