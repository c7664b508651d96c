"""MED meshes (.med) of Salome and Code_Aster, in HDF5.

1. Coordinates are one array: all x, then all y, then all z. They change in place.
2. Elements of a type have a family each; a family lists its groups, which are the markers. So
   do nodes.
3. Solids are listed with the normal of their first face inward; here they have VTK's order.
4. The first mesh of a file and its first step are read; others are named.

Source: EDF and CEA, "MED file format" (MED-fichier 4).
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.errors import InputError
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.cgns_nodes import HDF_ERRORS, is_inside, opened, values_of
from ffdstudio.meshes.formats.hdftemplate import DatasetPlace, HdfTemplate, Piece, template_of
from ffdstudio.meshes.formats.patch import BinaryTemplate
from ffdstudio.meshes.formats.source import Source, decoded
from ffdstudio.meshes.mesh import Markers, Mesh, MeshWarning
from ffdstudio.meshes.topology import Cells

KINDS: dict[str, tuple[str, list[int]]] = {  # MED's name -> type, nodes in VTK's order
    "PO1": ("vertex", [0]),
    "SE2": ("line", [0, 1]),
    "SE3": ("line3", [0, 1, 2]),
    "TR3": ("triangle", [0, 1, 2]),
    "TR6": ("triangle6", [0, 1, 2, 3, 4, 5]),
    "QU4": ("quad", [0, 1, 2, 3]),
    "QU8": ("quad8", [0, 1, 2, 3, 4, 5, 6, 7]),
    "QU9": ("quad9", [0, 1, 2, 3, 4, 5, 6, 7, 8]),
    "TE4": ("tetra", [0, 2, 1, 3]),
    "T10": ("tetra10", [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]),
    "PY5": ("pyramid", [0, 3, 2, 1, 4]),
    "PE6": ("wedge", [0, 2, 1, 3, 5, 4]),
    "HE8": ("hexahedron", [0, 3, 2, 1, 4, 7, 6, 5]),
}


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a MED mesh; see `read_mesh`."""
    source = Source(path, data)
    with opened(source) as file:
        try:
            return _Reader(source, file).mesh(progress)
        except HDF_ERRORS as error:
            if isinstance(error, InputError):
                raise
            raise source.failure(f"damaged HDF5 file ({type(error).__name__})") from error


class _Reader:
    """The first mesh of a file."""

    def __init__(self, source: Source, file: Any) -> None:
        self.source, self.file = source, file
        meshes = self._names(file, "ENS_MAA")
        if not meshes:
            raise source.failure("there is no mesh (ENS_MAA) in this file: no MED mesh?")
        self.name = meshes[0]
        steps = self._names(file, f"ENS_MAA/{self.name}")
        if not steps:
            raise source.failure(f"mesh {self.name} has no step")
        self.root = f"ENS_MAA/{self.name}/{steps[0]}"
        others = [*meshes[1:], *(f"step {step}" for step in steps[1:])]
        if others:
            self._warn(f"other meshes or steps are kept as they were: {', '.join(others)}")
        self.axes = int(file[f"ENS_MAA/{self.name}"].attrs.get("ESP", 3))
        self.unread: dict[str, int] = {}

    def _warn(self, message: str) -> None:
        warnings.warn(f"{self.source.path.name}: {message}", MeshWarning, stacklevel=3)

    def _names(self, group: Any, path: str) -> list[str]:
        """Groups in a group, reached without links."""
        for name in path.split("/"):
            if name not in group or not is_inside(group, name):
                return []
            group = group[name]
        return [name for name in group if is_inside(group, name) and hasattr(group[name], "keys")]

    def _values(self, path: str) -> Any:
        return values_of(self.source, self.file[path], path.rpartition("/")[2])

    def mesh(self, progress: Progress) -> Mesh:
        """Read the mesh."""
        template = self._template()
        progress(0.4)
        count = len(template.original)
        cells: Cells = {}
        markers: Markers = {}
        groups = self._groups("ELEME")
        for title in self._names(self.file, f"{self.root}/MAI"):
            kind, nodes = self._cells(title, count)
            if kind:
                cells[kind] = nodes
                self._mark(markers, groups, f"{self.root}/MAI/{title}/FAM", kind, nodes, title)
        vertices = np.arange(count)[:, None]
        at = f"{self.root}/NOE/FAM"
        self._mark(markers, self._groups("NOEUD"), at, "vertex", vertices, "nodes")
        return Mesh(
            template.original,
            cells,
            markers,
            dimension=self.axes,
            unread=self.unread,
            template=template,
        )

    def _template(self) -> BinaryTemplate | HdfTemplate:
        path = f"{self.root}/NOE/COO"
        if path not in self.file or self.axes not in (2, 3):
            raise self.source.failure("there are no coordinates in two or three dimensions")
        values, item = self._values(path).ravel(), self.file[path]
        if values.dtype.kind != "f" or len(values) % self.axes:
            raise self.source.failure("the coordinates do not fit their dimension")
        count = len(values) // self.axes
        points = np.zeros((count, 3))
        with np.errstate(invalid="ignore"):
            points[:, : self.axes] = values.reshape(self.axes, count).T
        if not np.isfinite(points).all():
            raise self.source.failure("a node has a coordinate that is not finite")
        offset = item.id.get_offset()
        place = DatasetPlace(f"/{path}", -1 if offset is None else offset, item.dtype)
        flat = np.arange(count)[:, None] + count * np.arange(self.axes)
        return template_of(
            self.source, points, [Piece((place,) * self.axes, flat, np.arange(count))]
        )

    def _cells(self, title: str, count: int) -> tuple[str, Indices]:
        """Type and nodes of the elements of a type; an empty name if it is not known."""
        path = f"{self.root}/MAI/{title}"
        if title not in KINDS:
            many = int(self.file[path].attrs.get("NBR", 0))
            for name in ("FAM", "NUM", "INN"):
                if name in self.file[path]:
                    many = max(many, int(self.file[path][name].size))
            self._warn(f"{many} elements of type {title} are kept but not shown")
            self.unread[title] = max(many, 1)
            return "", np.empty((0, 0), dtype=np.int64)
        kind, order = KINDS[title]
        flat = self._values(f"{path}/NOD").astype(np.int64).ravel()
        if len(flat) % len(order):
            raise self.source.failure(f"elements of type {title} have {len(order)} nodes")
        nodes: Indices = flat.reshape(len(order), -1).T[:, order] - 1
        if nodes.size and not (nodes.min() >= 0 and nodes.max() < count):
            raise self.source.failure(f"an element refers to a node not in 1 to {count}")
        return kind, nodes

    def _groups(self, which: str) -> dict[int, list[str]]:
        """Names of the groups of each family."""
        found: dict[int, list[str]] = {}
        base = f"FAS/{self.name}/{which}"
        for family in self._names(self.file, base):
            group = self.file[f"{base}/{family}"]
            names = []
            if "GRO" in group and "NOM" in group["GRO"]:
                raw = values_of(self.source, group["GRO"]["NOM"], "names of groups")
                rows = np.ascontiguousarray(raw).view(np.uint8).reshape(-1, 80)
                names = [decoded(row.tobytes().split(b"\0")[0]).strip() for row in rows]
            found[int(group.attrs.get("NUM", 0))] = names or [family] * (family != "FAMILLE_ZERO")
        return found

    def _mark(
        self,
        markers: Markers,
        groups: dict[int, list[str]],
        path: str,
        kind: str,
        nodes: Indices,
        title: str,
    ) -> None:
        """Add what the families of elements, or nodes, say."""
        if path not in self.file:
            return
        families = self._values(path).astype(np.int64).ravel()
        if len(families) != len(nodes):
            raise self.source.failure(f"the families of {title} do not fit")
        members: dict[str, list[int]] = {}
        for number in np.unique(families[families != 0]).tolist():
            for name in groups.get(number, [f"family {number}"]):
                members.setdefault(name, []).append(number)
        for name, numbers in members.items():
            chosen = nodes[np.isin(families, numbers)]
            own = markers.get(name, {})
            clash = kind == "vertex" and own and set(own) != {"vertex"}
            markers.setdefault(f"{name} (nodes)" if clash else name, {})[kind] = chosen
