"""Files of one cell each, of every kind that a format knows; made here, with no reader of ours."""

from __future__ import annotations

from pathlib import Path

import numpy as np

LINEAR = {
    "triangle": [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
    "quad": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
    "tetra": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "pyramid": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)],
    "wedge": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
    "hexahedron": [
        (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1),
    ],
}  # fmt: skip
EDGES = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "quad": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "tetra": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    "pyramid": [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)],
    "wedge": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    "hexahedron": [
        (0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4),
        (0, 4), (1, 5), (2, 6), (3, 7),
    ],
}  # fmt: skip


def serendipity(kind: str) -> np.ndarray:
    """Corners, then the middles of the edges in the order of `EDGES`, which is VTK's."""
    x = np.array(LINEAR[kind], dtype=float)
    return np.vstack([x, [(x[a] + x[b]) / 2 for a, b in EDGES[kind]]])


def prism(count: int) -> np.ndarray:
    angle = 2 * np.pi * np.arange(count) / count
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    return np.vstack([ring, ring + [0, 0, 1]])


# ---- VTK ----------------------------------------------------------------------------------

VTK_CORNERS = {5: "triangle", 9: "quad", 10: "tetra", 12: "hexahedron", 13: "wedge", 14: "pyramid"}
VTK_SECOND = {22: "triangle", 23: "quad", 24: "tetra", 25: "hexahedron", 26: "wedge", 27: "pyramid"}
VTK_OTHER = {28: 9, 29: 27, 30: 6, 31: 12, 32: 18, 33: 24, 34: 7, 37: 19}
VTK_LAGRANGE = [(69, 10), (70, 16), (71, 20), (72, 64), (73, 40), (69, 15), (71, 35), (72, 27)]
VTK_KINDS = [
    *VTK_CORNERS, *VTK_SECOND, *VTK_OTHER, 8, 11, 7, 15, 16, 42,
    *VTK_LAGRANGE, (74, 14), (74, 30), (76, 6), (77, 9), (78, 10), (79, 27), (80, 18),
    (81, 14), 41, 66,
]  # fmt: skip


def parametric(number: int, count: int) -> np.ndarray:
    """Where VTK itself has the nodes of its cells; somewhere for those that it cannot tell."""
    import vtk

    cell = vtk.vtkGenericCell.InstantiateCell(number)
    if cell is None or number in (41, 74, 81):
        return np.random.default_rng(number).random((count, 3))
    cell.GetPointIds().SetNumberOfIds(count)
    cell.GetPoints().SetNumberOfPoints(count)
    cell.Initialize()
    if hasattr(cell, "SetUniformOrderFromNumPoints"):
        cell.SetUniformOrderFromNumPoints(count)
    elif hasattr(cell, "SetOrderFromCellData") and number in (70, 72, 73, 77, 79, 80):
        pass
    flat = cell.GetParametricCoords()
    return np.array([flat[i] for i in range(3 * count)]).reshape(-1, 3)


def vtk_points(number) -> tuple[int, np.ndarray]:
    """VTK's number and node places of one cell."""
    number, count = number if isinstance(number, tuple) else (number, 0)
    if number in VTK_CORNERS:
        return number, np.array(LINEAR[VTK_CORNERS[number]], dtype=float)
    if number in VTK_SECOND:
        return number, serendipity(VTK_SECOND[number])
    if number in (8, 11):
        x = np.array(LINEAR["quad" if number == 8 else "hexahedron"], dtype=float)
        return number, x[[0, 1, 3, 2] if number == 8 else [0, 1, 3, 2, 4, 5, 7, 6]]
    if number == 7:
        return number, prism(5)[:5]
    if number in (15, 16):
        return number, prism(number - 10)
    if number == 42:
        return number, np.array(LINEAR["hexahedron"], dtype=float)
    return number, parametric(number, count or VTK_OTHER.get(number, 8))


HEX_FACES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]


def vtk_file(path: Path, number) -> Path:
    """One cell of a VTK type, as XML or in the legacy format; (number, nodes) of any order."""
    number, x = vtk_points(number)
    nodes = list(range(len(x)))
    stream = [len(HEX_FACES), *(n for face in HEX_FACES for n in (4, *face))]
    xyz = "\n".join(" ".join(map(repr, row)) for row in x.tolist())
    if path.suffix == ".vtk":
        row = stream if number == 42 else nodes
        path.write_text(
            "# vtk DataFile Version 4.2\none\nASCII\nDATASET UNSTRUCTURED_GRID\n"
            f"POINTS {len(x)} double\n{xyz}\nCELLS 1 {len(row) + 1}\n"
            f"{len(row)} {' '.join(map(str, row))}\nCELL_TYPES 1\n{number}\n"
        )
        return path
    arrays = {"connectivity": nodes, "offsets": [len(nodes)], "types": [number]}
    if number == 42:
        arrays |= {"faces": stream, "faceoffsets": [len(stream)]}
    text = "".join(
        f'<DataArray type="Int64" Name="{name}" format="ascii">{" ".join(map(str, values))}'
        "</DataArray>\n"
        for name, values in arrays.items()
    )
    path.write_text(
        '<VTKFile type="UnstructuredGrid" version="2.2"><UnstructuredGrid>\n'
        f'<Piece NumberOfPoints="{len(x)}" NumberOfCells="1"><Points>\n'
        f'<DataArray type="Float64" NumberOfComponents="3" format="ascii">{xyz}</DataArray>\n'
        f"</Points><Cells>{text}</Cells></Piece></UnstructuredGrid></VTKFile>\n"
    )
    return path


# ---- decks --------------------------------------------------------------------------------

ABAQUS = {
    "C3D4": "tetra", "C3D5": "pyramid", "C3D6": "wedge", "C3D8R": "hexahedron", "SC6R": "wedge",
    "SC8R": "hexahedron", "COH3D6": "wedge", "COH3D8": "hexahedron", "COD3D8": "hexahedron",
    "GK3D8": "hexahedron", "GK3D6": "wedge", "CIN3D8": "hexahedron", "EC3D8R": "hexahedron",
    "F3D8": "hexahedron", "DC3D4": "tetra", "AC3D8": "hexahedron", "Q3D8": "hexahedron",
    "S3": "triangle", "S4R": "quad", "STRI3": "triangle", "M3D4": "quad", "CPE4R": "quad",
    "CAX3": "triangle", "CAX4P": "quad", "COHAX4": "quad", "COH2D4": "quad", "SFM3D4R": "quad",
    "C3D10M": "tetra2", "C3D15": "wedge2", "C3D20R": "hexahedron2", "S6": "triangle2",
    "S8R5": "quad2", "STRI65": "triangle2", "CPE6M": "triangle2", "CPS8R": "quad2",
    "AC3D20": "hexahedron2", "C3D27": "hexahedron2", "GK3D12M": "wedge2", "CCL24": "hexahedron2",
    "U1001": "hexahedron", "PLANE": "quad",
}  # fmt: skip
NASTRAN = {
    "CTRIA3": "triangle", "CQUAD4": "quad", "CQUADR": "quad", "CTRIAR": "triangle",
    "CSHEAR": "quad", "CTRAX3": "triangle", "CQUADX4": "quad", "CTRIAX": "triangle",
    "CQUADX": "quad", "CPLSTN3": "triangle", "CPLSTN4": "quad", "CPLSTS4": "quad",
    "CTETRA": "tetra", "CPYRAM": "pyramid", "CPENTA": "wedge", "CHEXA": "hexahedron",
    "CIHEX1": "hexahedron", "CTWEDGE": "wedge", "CTRIA6": "triangle2", "CQUAD8": "quad2",
    "CTRAX6": "triangle2", "CPLSTS8": "quad2", "CIFHEX": "hexahedron", "CACINF4": "quad",
    "CHEXOTIC": "hexahedron",
}  # fmt: skip


def places(kind: str) -> np.ndarray:
    """Node places of a type; "quad2" is the one of second order."""
    return serendipity(kind[:-1]) if kind[-1] == "2" else np.array(LINEAR[kind], dtype=float)


def abaqus(path: Path, kind: str) -> Path:
    """One element of a type, of as many nodes as the table says."""
    x = places(ABAQUS[kind])
    rows = [", ".join([str(k), *map(repr, row)]) for k, row in enumerate(x.tolist(), 1)]
    nodes = [str(k) for k in range(1, len(x) + 1)]
    lines = [", ".join(["1", *nodes[:10]]), ", ".join(nodes[10:])]
    data = ",\n".join(line for line in lines if line)
    path.write_text("*NODE\n" + "\n".join(rows) + f"\n*ELEMENT, TYPE={kind}\n{data}\n")
    return path


def nastran(path: Path, card: str, more: str = "") -> Path:
    """One element of a card, and what else is to stand in the deck."""
    x = places(NASTRAN[card])
    rows = [f"GRID,{k},,{','.join(map(repr, row))}" for k, row in enumerate(x.tolist(), 1)]
    words = [card, "1", "1", *map(str, range(1, len(x) + 1))]
    lines = [",".join(words[:9]), *([",".join(["", *words[9:]])] if words[9:] else [])]
    path.write_text("BEGIN BULK\n" + "\n".join([*rows, *lines]) + f"\n{more}ENDDATA\n")
    return path


# ---- strips -------------------------------------------------------------------------------

_XYZ = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n"
STRIPS = {
    "a.ply": (
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
        "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
        f"{_XYZ}8 0 1 2 3 -1 2 3 4\n"
    ).encode(),
    "a.vtk": (
        "# vtk DataFile Version 3.0\nstrip\nASCII\nDATASET POLYDATA\nPOINTS 5 double\n"
        f"{_XYZ}TRIANGLE_STRIPS 1 6\n5 0 1 2 3 4\n"
    ).encode(),
    "a.vtp": (
        '<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="5" NumberOfStrips="1"><Points>'
        f'<DataArray type="Float64" NumberOfComponents="3" format="ascii">{_XYZ}</DataArray>'
        '</Points><Strips><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3 4'
        '</DataArray><DataArray type="Int64" Name="offsets" format="ascii">5</DataArray>'
        "</Strips></Piece></PolyData></VTKFile>"
    ).encode(),
}  # fmt: skip


# ---- CGNS ---------------------------------------------------------------------------------


def cgns_polyhedra(path: Path, offsets: bool) -> Path:
    """Two bricks as NGON_n and NFACE_n, with offsets as since 3.4 or with counts as before."""
    import h5py

    x = np.array([(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1, 2)], dtype=float)
    bricks = [[0, 1, 4, 3, 6, 7, 10, 9], [1, 2, 5, 4, 7, 8, 11, 10]]
    faces, cells = [], []
    for brick in bricks:
        cells.append([])
        for face in HEX_FACES:
            nodes = [brick[k] + 1 for k in face]
            known = [k for k, other in enumerate(faces) if set(other) == set(nodes)]
            cells[-1].append(-(known[0] + 1) if known else len(faces) + 1)
            faces += [] if known else [nodes]

    def node(parent, name, label, data=None, kind="MT"):
        group = parent.create_group(name)
        for key, value, size in (("name", name, 33), ("label", label, 33), ("type", kind, 3)):
            group.attrs.create(key, np.bytes_(value), dtype=f"S{size}")
        if data is not None:
            group.create_dataset(" data", data=data)
        return group

    def section(zone, name, number, rows, first):
        own = node(zone, name, "Elements_t", np.array([number, 0], np.int32), "I4")
        limits = np.array([first, first + len(rows) - 1], np.int32)
        node(own, "ElementRange", "IndexRange_t", limits, "I4")
        flat = [n for row in rows for n in (row if offsets else [len(row), *row])]
        node(own, "ElementConnectivity", "DataArray_t", np.array(flat, np.int32), "I4")
        if offsets:
            starts = np.cumsum([0, *map(len, rows)]).astype(np.int32)
            node(own, "ElementStartOffset", "DataArray_t", starts, "I4")

    def text(value):
        return np.frombuffer(value.encode(), np.int8)

    with h5py.File(path, "w") as file:
        base = node(file, "Base", "CGNSBase_t", np.array([3, 3], np.int32), "I4")
        zone = node(base, "Zone", "Zone_t", np.array([[12], [2], [0]], np.int32), "I4")
        node(zone, "ZoneType", "ZoneType_t", text("Unstructured"), "C1")
        grid = node(zone, "GridCoordinates", "GridCoordinates_t")
        for axis, values in zip("XYZ", x.T, strict=True):
            node(grid, f"Coordinate{axis}", "DataArray_t", values.copy(), "R8")
        section(zone, "Faces", 22, faces, 1)
        section(zone, "Cells", 23, cells, len(faces) + 1)
        wall = node(node(zone, "ZoneBC", "ZoneBC_t"), "hull", "BC_t", text("BCWall"), "C1")
        node(wall, "PointList", "IndexArray_t", np.array([[1]], np.int32), "I4")
        node(wall, "GridLocation", "GridLocation_t", text("FaceCenter"), "C1")
    return path
