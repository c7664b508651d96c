"""CGNS meshes, structured and unstructured, in ADF and in HDF5 files.

1. Coordinates are arrays of their own, one a direction and zone; only their numbers change.
2. Zones are joined and named if there are several. Boundary conditions become markers with
   their kind or their family's; without any, the sections of surface elements do. One that
   lists vertices gets the faces between these, or the vertices.
3. Cells that are lists of faces (NGON_n, NFACE_n) are kept but not shown.
4. Refused: cylindrical and other coordinates, links into other files, arrays in pieces.

Source: CGNS standard interface data structures (SIDS).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.cgns_boundaries import families_of
from ffdstudio.meshes.formats.cgns_nodes import Adf, Node, hdf5
from ffdstudio.meshes.formats.cgns_zones import Zones
from ffdstudio.meshes.formats.hdftemplate import HdfTemplate
from ffdstudio.meshes.formats.patch import BinaryTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import offsets_of
from ffdstudio.meshes.mesh import Mesh, Template

AXES = ("CoordinateX", "CoordinateY", "CoordinateZ")


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a CGNS file; see `read_mesh`."""
    source = Source(path, data)
    root = hdf5(source) if data.startswith(b"\x89HDF") else Adf(source).root()
    progress(0.5)
    bases = [base for base in root.of("CGNSBase_t") for _ in base.of("Zone_t")]
    zones = [zone for base in root.of("CGNSBase_t") for zone in base.of("Zone_t")]
    if not zones:
        raise source.failure("there is no zone in this file")
    coordinates = [_coordinates(source, zone) for zone in zones]
    counts = np.array([len(arrays[0].values()) for arrays in coordinates])
    template = _template(source, coordinates, counts)
    reader = Zones(source, len(zones) > 1)
    names = [zone.name for zone in zones]
    if len(set(names)) < len(names):  # the same in several bases
        names = [f"{base.name}/{name}" for base, name in zip(bases, names, strict=True)]
    begins = offsets_of(counts)[:-1].tolist()
    for zone, base, name, arrays, first in zip(
        zones, bases, names, coordinates, begins, strict=True
    ):
        reader.add(zone, arrays[0], first, families_of(base), name)
    joined = {kind: np.concatenate(parts) for kind, parts in reader.cells.items()}
    return Mesh(
        template.original,
        joined,
        reader.markers,
        dimension=len(coordinates[0]),
        kinds=reader.kinds,
        template=template,
    )


def _coordinates(source: Source, zone: Node) -> list[Node]:
    """Arrays of coordinates of a zone, two or three."""
    grid = zone.child("GridCoordinates") or next(zone.of("GridCoordinates_t"), None)
    if grid is None:
        raise source.failure(f"zone {zone.name} has no coordinates")
    found = [node for node in map(grid.child, AXES) if node is not None]
    names = [node.name for node in grid.of("DataArray_t")]
    if len(found) < 2 or [node.name for node in found] != list(AXES[: len(found)]):
        raise source.failure(f"zone {zone.name} has coordinates {', '.join(names)}, not x, y, z")
    for node in found:
        if (
            node.dtype is None
            or node.dtype.kind != "f"
            or len(node.values()) != len(found[0].values())
        ):
            raise source.failure(f"zone {zone.name}: {node.name} is damaged")
    return found


def _template(source: Source, zones: list[list[Node]], counts: Indices) -> Template:
    axes = len(zones[0])
    dtypes = {node.dtype for arrays in zones for node in arrays if node.dtype is not None}
    if len(dtypes) > 1 or any(len(arrays) != axes for arrays in zones):
        raise source.failure("zones with different kinds of coordinates in one file")
    dtype = dtypes.pop()
    points = np.zeros((int(counts.sum()), 3))
    places = np.empty((len(points), axes), dtype=np.int64)
    arrays = []
    for zone, first, count in zip(zones, offsets_of(counts), counts, strict=False):
        part = slice(first, first + count)
        for axis, node in enumerate(zone):
            with np.errstate(invalid="ignore"):
                points[part, axis] = node.values()
            places[part, axis] = node.place + dtype.itemsize * np.arange(count)
            arrays.append((node.path, axis, int(first), int(count)))
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise source.failure(f"node {bad[0]} (counted from 0) has a coordinate that is not finite")
    if any(node.place < 0 for zone in zones for node in zone):
        return HdfTemplate(source, points, arrays, axes, dtype)
    return BinaryTemplate(source.data, points, dtype, places)
