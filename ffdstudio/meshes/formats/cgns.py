"""CGNS meshes, structured and unstructured, in ADF and in HDF5 files.

1. Coordinates are arrays of their own, one a direction and zone; only their numbers change.
2. Zones are joined and named if there are several. Boundary conditions become markers with
   their kind or their family's, and so do sections of surface elements that no condition
   covers. Conditions of one family are one marker under the family's name, in all zones.
   One that lists vertices gets the faces between these, or the vertices.
3. Rind planes are no part of the mesh; those of their nodes that are copies of a node in a
   zone move with it. Connections of vertices become links.
4. Cells that are lists of faces (NGON_n, NFACE_n) are kept but not shown.
5. Refused: cylindrical and other coordinates, links into other files, arrays in pieces.

Source: CGNS standard interface data structures (SIDS).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ffdstudio.meshes.formats import Progress
from ffdstudio.meshes.formats.cgns_boundaries import families_of
from ffdstudio.meshes.formats.cgns_grids import Grid, copies_in_rind, grid_of
from ffdstudio.meshes.formats.cgns_links import Spot, links_of
from ffdstudio.meshes.formats.cgns_nodes import Adf, Node, hdf5
from ffdstudio.meshes.formats.cgns_zones import Zones
from ffdstudio.meshes.formats.hdftemplate import DatasetPlace, HdfTemplate, Piece, template_of
from ffdstudio.meshes.formats.patch import BinaryTemplate
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import offsets_of
from ffdstudio.meshes.mesh import Mesh


def read(path: Path, data: bytes, progress: Progress) -> Mesh:
    """Read a CGNS file; see `read_mesh`."""
    source = Source(path, data)
    root = hdf5(source) if data.startswith(b"\x89HDF") else Adf(source).root()
    progress(0.5)
    zones = [(base, zone) for base in root.of("CGNSBase_t") for zone in base.of("Zone_t")]
    if not zones:
        raise source.failure("there is no zone in this file")
    grids = [grid_of(source, zone) for _, zone in zones]
    template = _template(source, grids)
    names = [zone.name for _, zone in zones]
    if len(set(names)) < len(names):  # the same in several bases
        names = [f"{base.name}/{zone.name}" for base, zone in zones]
    reader = Zones(source, len(zones) > 1, _version(root))
    begins = offsets_of(np.array([len(grid.kept) for grid in grids])).tolist()
    places: dict[tuple[str, str], Spot] = {}
    for (base, zone), grid, name, first in zip(zones, grids, names, begins, strict=False):
        reader.add(zone, grid, first, families_of(base), name)
        prefix = f"{name}/" if len(zones) > 1 else ""
        places[base.name, zone.name] = Spot(base.name, zone, grid.dims, first, prefix)
    return reader.mesh(
        template.original,
        dimension=len(grids[0].arrays),
        links=tuple(links_of(source, places)),
        template=template,
    )


def _version(root: Node) -> float:
    """Version of the library that wrote the file."""
    found = next(root.of("CGNSLibraryVersion_t"), None)
    values = np.empty(0) if found is None else found.values()
    return float(values[0]) if len(values) and values.dtype.kind == "f" else 0.0


def _template(source: Source, grids: list[Grid]) -> BinaryTemplate | HdfTemplate:
    parts = [grid.points() for grid in grids]
    points = np.concatenate([part[grid.kept] for part, grid in zip(parts, grids, strict=True)])
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise source.failure(f"node {bad[0]} (counted from 0) has a coordinate that is not finite")
    copies = copies_in_rind(source, grids, parts, points)
    pieces, first = [], 0
    for grid, (rows, nodes) in zip(grids, copies, strict=True):
        arrays = tuple(DatasetPlace(node.path, node.place, _type(node)) for node in grid.arrays)
        index = np.concatenate([grid.kept, rows])
        own = np.concatenate([first + np.arange(len(grid.kept)), nodes])
        pieces.append(Piece(arrays, np.repeat(index[:, None], len(arrays), axis=1), own))
        first += len(grid.kept)
    return template_of(source, points, pieces)


def _type(node: Node) -> np.dtype:
    assert node.dtype is not None
    return node.dtype
