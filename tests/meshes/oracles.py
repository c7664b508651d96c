"""Independent readers: what others find in a file that was written here."""

from __future__ import annotations

import contextlib
import io
import itertools
import re
from pathlib import Path

import numpy as np

NUMBER = rb"[-+]?[\d.]+(?:[eE][-+]?\d+)?"


def with_meshio(path: Path) -> np.ndarray:
    import meshio

    with contextlib.redirect_stdout(io.StringIO()):
        points = meshio.read(path).points
    return np.hstack([points, np.zeros((len(points), 3 - points.shape[1]))])


def with_vtk(path: Path) -> np.ndarray:
    import pyvista

    return np.asarray(pyvista.read(path).points)


def by_words(word: str):
    """Oracle that reads the three numbers behind a word wherever it begins a line."""

    def read(path: Path) -> np.ndarray:
        text = path.read_text(encoding="utf-8-sig")
        rows = re.findall(rf"^\s*{word}\s+(\S+)\s+(\S+)\s+(\S+)", text, re.M)
        return np.array([[float(number) for number in row] for row in rows])

    return read


def binary_stl(path: Path) -> np.ndarray:
    record = np.dtype([("n", "<f4", 3), ("v", "<f4", 9), ("a", "<u2")])
    return np.fromfile(path, record, offset=84)["v"].reshape(-1, 3)


def with_gmsh(path: Path) -> np.ndarray:
    """Points by tag, as Gmsh itself reads them."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        tags, xyz, _ = gmsh.model.mesh.getNodes()
    finally:
        gmsh.finalize()
    return xyz.reshape(-1, 3)[np.argsort(tags)]


def ply_text(path: Path) -> np.ndarray:
    """Vertices of a text whose header is known: VTK and meshio lose digits or the file."""
    lines = path.read_text().split("end_header\n")[1].splitlines()[:12]
    return np.array([[float(word) for word in line.split()] for line in lines])


def off_text(path: Path) -> np.ndarray:
    """Twelve vertices behind the counts."""
    lines = path.read_text().split("\n12 3 0\n")[1].splitlines()[:12]
    return np.array([[float(word) for word in line.split()[:3]] for line in lines])


def unv_nodes(path: Path) -> np.ndarray:
    """Columns of 25 characters of the second line of each node, as Fortran reads them."""
    lines = path.read_text().split("  2411\n")[1].split("\n    -1\n")[0].splitlines()[1::2]
    cut = [[line[k : k + 25].replace("D", "E") for k in (0, 25, 50)] for line in lines]
    return np.array(cut, dtype=float)


def med_nodes(path: Path) -> np.ndarray:
    import h5py

    with h5py.File(path) as file:
        mesh = next(iter(file["ENS_MAA"].values()))
        return next(iter(mesh.values()))["NOE/COO"][()].reshape(3, -1).T


def everyday_text(path: Path) -> np.ndarray:
    """Columns of a PLOT3D block in text, counts before a star written out."""
    text = re.sub(r"(\d+)\*(\S+?)(?=[\s,]|$)", lambda m: f"{m[2]} " * int(m[1]), path.read_text())
    words = text.replace(",", " ").split()
    skipped, axes = {".p2dfmt": (3, 2), ".xyz": (4, 3)}.get(path.suffix, (3, 3))
    columns = np.array(words[skipped:], dtype=float).reshape(axes, -1)
    return np.vstack([columns, np.zeros((3 - axes, columns.shape[1]))]).T


def everyday_records(path: Path) -> np.ndarray:
    """Two blocks of twelve nodes whose coordinates are records of their own."""
    data, found = path.read_bytes(), []
    for block in range(2):
        begins = [12 + 32 + 4 + (96 + 8) * (3 * block + axis) for axis in range(3)]
        found.append(np.stack([np.frombuffer(data, "<f8", 12, at) for at in begins], axis=1))
    return np.concatenate(found)


def ugrid_wide(path: Path) -> np.ndarray:
    order = "<" if ".l" in path.name else ">"
    return np.frombuffer(path.read_bytes(), f"{order}f8", 36, 56).reshape(-1, 3)


def fluent_binary(path: Path) -> np.ndarray:
    """Numbers of the only binary section of nodes."""
    data = path.read_bytes()
    match = re.search(rb"\(([23])010 \(1 1 (\w+) 1 3\)\(", data)
    assert match
    dtype = np.dtype("<f8" if match[1] == b"3" else "<f4")
    return np.frombuffer(data, dtype, 3 * int(match[2], 16), match.end()).reshape(-1, 3)


def fluent_hdf(path: Path) -> np.ndarray:
    import h5py

    with h5py.File(path) as file:
        zones = file["meshes/1/nodes/coords"]
        return np.concatenate([zones[name][()] for name in sorted(zones, key=int)])


def fluent_nodes(path: Path) -> np.ndarray:
    """Numbers of all zones of nodes, in the order of their first node."""
    zones = re.findall(r"^\(10 \((\w+ \w+)[^()]*\)\s*\(([^()]*)\)", path.read_text(), re.M)
    zones.sort(key=lambda zone: int(zone[0].split()[1], 16))
    rows = [line.split() for _, body in zones for line in body.splitlines() if line.strip()]
    return np.array([[float(word) for word in row] + [0.0] * (3 - len(row)) for row in rows])


def avs_nodes(path: Path) -> np.ndarray:
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    count = int(lines[0].split()[0])
    return np.array([[float(word) for word in line.split()[1:4]] for line in lines[1 : count + 1]])


def ugrid_records(dtype: str):
    """Oracle for files with record marks, which meshio does not read."""

    def read(path: Path) -> np.ndarray:
        data = path.read_bytes()
        count = int(np.frombuffer(data, dtype[0] + "i4", 1, 4)[0])
        return np.frombuffer(data, dtype, 3 * count, 40).reshape(-1, 3)

    return read


def plot3d_text(path: Path) -> np.ndarray:
    words = path.read_text().split()
    blocks = int(words[0]) if words[0] != "4" else 1
    at = 1 if words[0] != "4" else 0
    shapes = np.array(words[at : at + 3 * blocks], dtype=int).reshape(-1, 3)
    at += 3 * blocks
    found = []
    for count in shapes.prod(axis=1):
        found.append(np.array(words[at : at + 3 * count], dtype=float).reshape(3, -1).T)
        at += (4 if "blank" in path.name else 3) * count
    return np.concatenate(found)


def plot3d_binary(path: Path) -> np.ndarray:
    """By VTK, which has to be told what the file is."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkMultiBlockPLOT3DReader()
    reader.SetFileName(str(path))
    reader.AutoDetectFormatOff()
    reader.SetMultiGrid("single" not in path.name)
    reader.SetHasByteCount("fortran" in path.name)
    reader.SetIBlanking("blank" in path.name)
    reader.SetByteOrder(1 if "little" in path.name else 0)
    reader.SetDoublePrecision("float" not in path.name)
    reader.Update()
    blocks = reader.GetOutput()
    grids = [blocks.GetBlock(k) for k in range(blocks.GetNumberOfBlocks())]
    return np.concatenate([vtk_to_numpy(grid.GetPoints().GetData()) for grid in grids])


def ugrid_text(path: Path) -> np.ndarray:
    """Text that meshio reads in single precision."""
    words = path.read_text().split()
    return np.array(words[7 : 7 + 3 * int(words[0])], dtype=float).reshape(-1, 3)


def cgns_with_vtk(path: Path) -> np.ndarray:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    vtk.vtkObject.GlobalWarningDisplayOff()
    reader = vtk.vtkCGNSReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    reader.EnableAllBases()
    reader.DoublePrecisionMeshOn()
    reader.Update()
    walk = reader.GetOutput().NewIterator()
    found = []
    while not walk.IsDoneWithTraversal():
        found.append(vtk_to_numpy(walk.GetCurrentDataObject().GetPoints().GetData()))
        walk.GoToNextItem()
    return np.concatenate(found)


def cgns_with_h5py(path: Path) -> np.ndarray:
    import h5py

    with h5py.File(path) as file:
        grid = file["Base/Zone/GridCoordinates"]
        return np.stack([grid[f"Coordinate{axis}/ data"][:] for axis in "XYZ"], axis=1)


def exodus_with_netcdf(path: Path) -> np.ndarray:
    import netCDF4

    with netCDF4.Dataset(path) as file:
        return np.stack([np.asarray(file[f"coord{axis}"][:]) for axis in "xyz"], axis=1)


def nastran_large(path: Path) -> np.ndarray:
    """Coordinates of a deck of GRID* alone, by the columns of its lines."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("$")]
    found = []
    for line, second in itertools.pairwise(lines):
        if line.startswith("GRID*"):
            words = [line[40:56], line[56:72], second[8:24]]
            found.append([float(re.sub(r"(?<=[\d.])([+-])", r"e\1", word)) for word in words])
    return np.array(found)


def abaqus_nodes(path: Path) -> np.ndarray:
    """Coordinates of the only block of nodes, blanks as zeros."""
    block = path.read_text().split("*")[1].splitlines()[1:]
    return np.array([[float(word.strip() or 0) for word in row.split(",")[1:4]] for row in block])


def su2_zones(path: Path) -> np.ndarray:
    """Nodes of all zones, three coordinates a line."""
    parts = path.read_text(encoding="utf-8-sig").split("NPOIN= ")[1:]
    rows = [row for part in parts for row in part.splitlines()[1 : 1 + int(part.split()[0])]]
    return np.array([[float(word) for word in row.split()[:3]] for row in rows])
