"""Small files of every format, made by other programs or by hand, for the table of formats."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.meshes import everyday_specimens as everyday
from tests.meshes import exchange_specimens as exchange
from tests.meshes.cgns_specimens import as_adf, hexa_zone
from tests.meshes.decks import abaqus_with_blanks, nastran_with_comments, su2_with_boxes
from tests.meshes.fluent_specimens import fluent_hdf, fluent_sector
from tests.meshes.gmsh_specimens import gmsh_40_binary, gmsh_box, gmsh_periodic

GRID = (4, 3, 3)


def grid_points() -> np.ndarray:
    """Points of a wavy block that no format holds exactly in a few digits."""
    i, j, k = np.meshgrid(*(np.arange(n) for n in GRID), indexing="ij")
    xyz = np.stack([i + 0.1 * np.sin(j), j / 3 + 0.01 * k, k / 7 + 0.1 * np.cos(i)], axis=-1)
    return xyz.transpose(2, 1, 0, 3).reshape(-1, 3)


def hexahedra() -> np.ndarray:
    nx, ny, nz = GRID
    cells = []
    for k in range(nz - 1):
        for j in range(ny - 1):
            for i in range(nx - 1):
                a = i + nx * (j + ny * k)
                low = [a, a + 1, a + 1 + nx, a + nx]
                cells.append(low + [n + nx * ny for n in low])
    return np.array(cells)


def vtk_grid(dtype: type = np.float64):
    import pyvista as pv

    cells = hexahedra()
    flat = np.hstack([np.full((len(cells), 1), 8), cells]).ravel()
    return pv.UnstructuredGrid(flat, np.full(len(cells), 12), grid_points().astype(dtype))


def vtk_legacy(path: Path, binary: bool, version: int) -> None:
    import vtk

    writer = vtk.vtkUnstructuredGridWriter()
    writer.SetInputData(vtk_grid())
    writer.SetFileVersion(version)
    writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()
    writer.SetFileName(str(path))
    writer.Write()


def vtk_xml(
    path: Path, mode: str, compress: bool | str = False, raw: bool = False, dtype: type = np.float64
) -> None:
    import vtk

    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(vtk_grid(dtype))
    getattr(writer, f"SetDataModeTo{mode}")()
    kind = compress if isinstance(compress, str) else "ZLib" if compress else "None"
    getattr(writer, f"SetCompressorTypeTo{kind}")()
    writer.SetBlockSize(600)
    if raw:
        writer.EncodeAppendedDataOff()
    writer.SetFileName(str(path))
    writer.Write()


def surface(path: Path, binary: bool) -> None:
    """STL or PLY of the block's skin, written by VTK."""
    vtk_grid(np.float32).extract_surface(algorithm="dataset_surface").triangulate().save(
        path, binary=binary
    )


def ply_double(path: Path) -> None:
    import meshio

    quads = hexahedra()[:, [0, 3, 2, 1]]
    meshio.write_points_cells(path, grid_points(), [("quad", quads.astype(np.int32))])


OBJ = "o block\n{}\ng low\nf 1/1 2/2 6/3 5/4\ng high\nf -1 -2 -6\nl 1 2\n"


def obj(path: Path) -> None:
    rows = [f"v {x:.6f} {y!r}  {z} # {k}" for k, (x, y, z) in enumerate(grid_points().tolist())]
    path.write_text(OBJ.format("\n".join(rows)))


def hexahedron_faces() -> tuple[list[list[int]], list[int], list[int]]:
    """Faces of the block, owners and neighbours (-1 outside), inner faces first."""
    local = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)]
    seen: dict[tuple, list] = {}
    for cell, nodes in enumerate(hexahedra().tolist()):
        for face in local:
            corners = [nodes[k] for k in face]
            seen.setdefault(tuple(sorted(corners)), [corners]).append(cell)
    found = sorted(seen.values(), key=lambda entry: len(entry) == 2)
    return (
        [entry[0] for entry in found],
        [entry[1] for entry in found],
        [entry[2] if len(entry) == 3 else -1 for entry in found],
    )


def fluent(path: Path) -> None:
    """Two zones of nodes, quads of a fixed size inside, mixed faces with cell 0 first outside."""
    faces, owner, neighbour = hexahedron_faces()
    inner = sum(cell >= 0 for cell in neighbour)
    rows = [" ".join(f"{x!r}" for x in row) for row in grid_points().tolist()]
    inside = [
        " ".join(f"{n + 1:x}" for n in face) + f" {a + 1:x} {b + 1:X}"
        for face, a, b in zip(faces[:inner], owner, neighbour, strict=False)
    ]
    outside = [
        "4 " + " ".join(f"{n + 1:x}" for n in face[::-1]) + f" 0 {a + 1:x}"
        for face, a in zip(faces[inner:], owner[inner:], strict=True)
    ]
    listed = ["\n".join(part) for part in (rows[:10], rows[10:], inside, outside)]
    path.write_text(
        f"""(0 "a comment with (10 (1 1 2 1 3)( in it")
(2 3)
(10 (0 1 {len(rows):x} 0 3))
(10 (7 1 a 1 3)(
{listed[0]}
))
(10 (8 b {len(rows):x} 1 3)
(
{listed[1]}))
(12 (0 1 c 0))
(12 (2 1 c 1 4))
(13 (0 1 {len(faces):x} 0))
(13 (3 1 {inner:x} 2 4)(
{listed[2]}))
(13 (4 {inner + 1:x} {len(faces):x} 3 0)(
{listed[3]}))
(45 (4 wall outside)())
(45 (3 interior inside)())
"""
    )


def ugrid(path: Path) -> None:
    """Two triangles, a quad with boundary numbers, and all kinds of cells; a name tells how."""
    points = grid_points()
    cube = hexahedra()[0]
    cells = {
        "tri": ([cube[[0, 1, 4]], cube[[1, 5, 4]]], [3, 1]),
        "quad": ([cube[[0, 1, 2, 3]]], [3]),
    }
    volume = [cube[[0, 1, 3, 4]], cube[[0, 4, 6, 1, 5]], hexahedra()[1][:6], hexahedra()[2]]
    counts = [len(points), 2, 1, 1, 1, 1, 1]
    whole = [cube + 1 for cube in cells["tri"][0] + cells["quad"][0]]
    whole += [np.array([3, 1, 3])] + [nodes + 1 for nodes in volume]
    flat = np.concatenate(whole)
    layout = path.name.split(".")[-2]
    if layout == "text":
        rows = [" ".join(map(str, counts)), *(" ".join(map(repr, p)) for p in points.tolist())]
        path.write_text("\n".join([*rows, *(" ".join(map(str, row)) for row in whole), ""]))
        return
    order = "<" if layout[0] == "l" else ">"
    body = points.astype(f"{order}f{layout[-1]}").tobytes() + flat.astype(f"{order}i4").tobytes()
    head = np.array(counts, f"{order}i4").tobytes()
    if "r" in layout:
        head, body = (
            np.array([len(record)], f"{order}i4").tobytes().join([b"", record, b""])
            for record in (head, body)
        )
    path.write_bytes(head + body)


def plot3d(path: Path) -> None:
    """Two blocks (one in `single`), text or binary; a name tells how."""
    points, name = grid_points(), path.stem
    blocks = [(GRID, points)]
    if "single" not in name:
        blocks.append(((2, 3, 1), points[:6] + 10))
    header = [*([len(blocks)] if "single" not in name else []), *(n for b in blocks for n in b[0])]
    blank = "blank" in name
    if "text" in name:
        rows = [" ".join(map(str, header))]
        for _, xyz in blocks:
            rows += [" ".join(map(repr, column)) for column in xyz.T.tolist()]
            rows += [" ".join(["1"] * len(xyz))] * blank
        path.write_text("\n".join(rows) + "\n")
        return
    order, real = ("<" if "little" in name else ">"), ("f4" if "float" in name else "f8")
    records = [np.array(part, f"{order}i4").tobytes() for part in (header[:1], header[1:])]
    if "single" in name:
        records = [b"".join(records)]
    for _, xyz in blocks:
        body = xyz.T.astype(order + real).tobytes()
        records.append(body + np.ones(len(xyz), f"{order}i4").tobytes() * blank)
    marked = "fortran" in name
    marks = [np.array([len(r)], f"{order}i4").tobytes() * marked for r in records]
    path.write_bytes(b"".join(m + r + m for m, r in zip(marks, records, strict=True)))


def cgns_hdf5(path: Path, **storage) -> None:
    """Unstructured zone in HDF5 as the CGNS library lays it out."""
    import h5py

    def node(parent, name, label, data=None, kind="MT", **options):
        group = parent.create_group(name)
        for key, value, size in (("name", name, 33), ("label", label, 33), ("type", kind, 3)):
            group.attrs.create(key, np.bytes_(value), dtype=f"S{size}")
        if data is not None:
            group.create_dataset(" data", data=data, **options)
        return group

    def text(value):
        return np.frombuffer(value.encode(), np.int8)

    cells = hexahedra() + 1
    quads = cells[:, :4]
    with h5py.File(path, "w") as file:
        base = node(file, "Base", "CGNSBase_t", np.array([3, 3], np.int32), "I4")
        sizes = np.array([[len(grid_points())], [len(cells)], [0]], np.int32)
        zone = node(base, "Zone", "Zone_t", sizes, "I4")
        node(zone, "ZoneType", "ZoneType_t", text("Unstructured"), "C1")
        grid = node(zone, "GridCoordinates", "GridCoordinates_t")
        for axis, values in zip("XYZ", grid_points().T, strict=True):
            node(grid, f"Coordinate{axis}", "DataArray_t", values.copy(), "R8", **storage)
        last = len(cells)
        for name, number, nodes in (("Hexas", 17, cells), ("Low", 7, quads)):
            section = node(zone, name, "Elements_t", np.array([number, 0], np.int32), "I4")
            limits = np.array([last - len(cells) + 1, last], np.int32)
            node(section, "ElementRange", "IndexRange_t", limits, "I4")
            node(section, "ElementConnectivity", "DataArray_t", nodes.ravel().astype("i4"), "I4")
            last += len(cells)
        conditions = node(zone, "ZoneBC", "ZoneBC_t")
        wall = node(conditions, "hull", "BC_t", text("BCWallViscous"), "C1")
        limits = np.array([[len(cells) + 1], [len(cells) + 3]], np.int32)
        node(wall, "PointRange", "IndexRange_t", limits, "I4")
        node(wall, "GridLocation", "GridLocation_t", text("FaceCenter"), "C1")


def exodus(path: Path, **options) -> None:
    """Hexahedra with a side set and a node set, through the netCDF library."""
    import netCDF4

    storage = options.pop("storage", {})
    cells = hexahedra()
    with netCDF4.Dataset(path, "w", **options) as file:
        for name, size in (
            *(("num_nodes", len(grid_points())), ("num_el_in_blk1", len(cells))),
            *(("num_nod_per_el1", 8), ("num_side_ss1", 2), ("num_nod_ns1", 3), ("len_string", 33)),
            ("num_side_sets", 1),
        ):
            file.createDimension(name, size)
        for axis, values in zip("xyz", grid_points().T, strict=True):
            file.createVariable(f"coord{axis}", "f8", ("num_nodes",), **storage)[:] = values
        nodes = file.createVariable("connect1", "i4", ("num_el_in_blk1", "num_nod_per_el1"))
        nodes.elem_type = "HEX8"
        nodes[:] = cells + 1
        file.createVariable("elem_ss1", "i4", ("num_side_ss1",))[:] = [1, 2]
        file.createVariable("side_ss1", "i4", ("num_side_ss1",))[:] = [5, 5]
        file.createVariable("node_ns1", "i4", ("num_nod_ns1",))[:] = [1, 2, 3]
        names = file.createVariable("ss_names", "S1", ("num_side_sets", "len_string"))
        names[:] = netCDF4.stringtochar(np.array(["floor"], "S33"))


SPECIMENS: dict[str, Callable[[Path], None]] = {
    "old.vtk": lambda path: vtk_legacy(path, False, 42),
    "old_binary.vtk": lambda path: vtk_legacy(path, True, 42),
    "new.vtk": lambda path: vtk_legacy(path, False, 51),
    "new_binary.vtk": lambda path: vtk_legacy(path, True, 51),
    "ascii.vtu": lambda path: vtk_xml(path, "Ascii"),
    "inline.vtu": lambda path: vtk_xml(path, "Binary"),
    "inline_packed.vtu": lambda path: vtk_xml(path, "Binary", True),
    "appended.vtu": lambda path: vtk_xml(path, "Appended"),
    "appended_packed.vtu": lambda path: vtk_xml(path, "Appended", True),
    "raw.vtu": lambda path: vtk_xml(path, "Appended", raw=True),
    "raw_packed.vtu": lambda path: vtk_xml(path, "Appended", True, raw=True),
    "single.vtu": lambda path: vtk_xml(path, "Appended", raw=True, dtype=np.float32),
    "lz4.vtu": lambda path: vtk_xml(path, "Appended", "LZ4", raw=True),
    "lzma.vtu": lambda path: vtk_xml(path, "Binary", "LZMA"),
    "mark.su2": everyday.su2_with_mark,
    "mark.obj": everyday.obj_with_mark,
    "repeats.xyz": everyday.plot3d_repeats,
    "records.x": everyday.plot3d_records,
    "plane.p2dfmt": everyday.plot3d_plain,
    "plain.grd": everyday.plot3d_plain,
    "plain.g": everyday.plot3d_plain,
    "wide.lb8l.ugrid": everyday.ugrid_wide,
    "wide.b8l.ugrid": everyday.ugrid_wide,
    "scalar_first.ply": everyday.ply_scalar_first,
    "blank_line.vtk": everyday.vtk_blank_line,
    "zero.stl": everyday.stl_of_a_stream,
    "most.stl": everyday.stl_of_a_stream,
    "text.mesh": exchange.medit,
    "binary.meshb": exchange.medit,
    "single.meshb": lambda path: exchange.medit(path, 1),
    "long.meshb": lambda path: exchange.medit(path, 4),
    "plain.off": exchange.off,
    "normals.off": lambda path: exchange.off(path, "NOFF"),
    "box.unv": exchange.by_gmsh,
    "quadratic.unv": lambda path: exchange.by_gmsh(path, 2),
    "box.med": exchange.by_gmsh,
    "quadratic.med": lambda path: exchange.by_gmsh(path, 2),
    "binary.stl": lambda path: surface(path, True),
    "ascii.stl": lambda path: surface(path, False),
    "binary.ply": lambda path: surface(path, True),
    "ascii.ply": lambda path: surface(path, False),
    "double.ply": ply_double,
    "block.obj": obj,
    "plain.cgns": cgns_hdf5,
    "adf_a.cgns": lambda path: as_adf(path, hexa_zone(), binary=False),
    "adf_b.cgns": lambda path: as_adf(path, hexa_zone()),
    "adf_b_big.cgns": lambda path: as_adf(path, hexa_zone(), order=">"),
    "packed.cgns": lambda path: cgns_hdf5(path, chunks=(10,), compression="gzip"),
    "classic.exo": lambda path: exodus(path, format="NETCDF3_CLASSIC"),
    "wide.exo": lambda path: exodus(path, format="NETCDF3_64BIT_DATA"),
    "hdf5.exo": exodus,
    "packed.exo": lambda path: exodus(path, storage={"zlib": True}),
    **{f"{name}.ugrid": ugrid for name in ("a.text", "a.b8", "a.lb8", "a.b4", "a.lr8", "a.r4")},
    **{
        f"{name}.xyz": plot3d
        for name in (
            *("text", "text_blank", "text_single", "little", "big_single", "little_float"),
            *("big_fortran", "little_fortran_blank", "little_fortran_single"),
        )
    },
    "block_fluent.msh": fluent,
    "sector_fluent.msh": fluent_sector,
    "sector_double.cas": lambda path: fluent_sector(path, 3),
    "sector_single.msh": lambda path: fluent_sector(path, 2),
    "sector.cas.h5": fluent_hdf,
    "zones.msh.h5": lambda path: fluent_hdf(path, zones=3),
    "packed.cas.h5": lambda path: fluent_hdf(path, chunks=True, compression="gzip"),
    "sector_mixed.cas": lambda path: fluent_sector(path, 3, mixed=True),
    "v1.msh": lambda path: gmsh_box(path, 1, False),
    "v22.msh": lambda path: gmsh_box(path, 2.2, False),
    "v22_binary.msh": lambda path: gmsh_box(path, 2.2, True),
    "v40.msh": lambda path: gmsh_box(path, 4.0, False),
    "v40_parametric.msh": lambda path: gmsh_box(path, 4.0, False, True),
    "v40_binary.msh": gmsh_40_binary,
    "v22_periodic.msh": lambda path: gmsh_periodic(path, 2.2, False),
    "v22_periodic_binary.msh": lambda path: gmsh_periodic(path, 2.2, True),
    "v40_periodic.msh": lambda path: gmsh_periodic(path, 4.0, False),
    "v41_periodic.msh": lambda path: gmsh_periodic(path, 4.1, False, True),
    "v41_periodic_binary.msh": lambda path: gmsh_periodic(path, 4.1, True),
    "v41.msh": lambda path: gmsh_box(path, 4.1, False),
    "v41_parametric.msh": lambda path: gmsh_box(path, 4.1, False, True),
    "v41_binary.msh": lambda path: gmsh_box(path, 4.1, True),
    "v41_binary_parametric.msh": lambda path: gmsh_box(path, 4.1, True, True),
    "v22_two_groups.msh": lambda path: gmsh_box(path, 2.2, False, groups=2),
    "v22_two_groups_binary.msh": lambda path: gmsh_box(path, 2.2, True, groups=2),
    "v41_partitioned.msh": lambda path: gmsh_box(path, 4.1, False, partitions=2),
    "v41_partitioned_binary.msh": lambda path: gmsh_box(path, 4.1, True, partitions=2),
    "comments.bdf": nastran_with_comments,
    "blanks.inp": abaqus_with_blanks,
    "zones_with_boxes.su2": su2_with_boxes,
}
