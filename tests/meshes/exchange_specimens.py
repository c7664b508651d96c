"""Meshes of exchange formats: Medit, MED, OFF, universal files, VTK's blocks and pieces."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.meshes.everyday_specimens import CELLS, POINTS


def by_gmsh(path: Path, order: int = 1, plane: bool = False) -> None:
    """Box, or rectangle, with named groups, in whatever format the suffix says."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        occ.addRectangle(0, 0, 0, 1, 1 / 3) if plane else occ.addBox(0, 0, 0, 1, 1 / 3, 1 / 7)
        occ.synchronize()
        dim = 1 if plane else 2
        gmsh.model.addPhysicalGroup(dim, [1, 2], 7, name="wall")
        gmsh.model.addPhysicalGroup(dim + 1, [1], 9, name="fluid")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.4)
        gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 0)
        gmsh.option.setNumber("Mesh.SaveElementTagType", 2)
        gmsh.model.mesh.generate(dim + 1)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def medit(path: Path, version: int = 2) -> None:
    """Binary or text by the suffix; all kinds of cells with references."""
    cube = np.array(CELLS[0]) + 1
    parts = {
        5: [[1, 2, 0], [2, 3, 4]],
        6: [[1, 2, 4, 3], [2, 5, 4, 0]],
        7: [[*cube[:4], 3]],
        8: [[1, 2, 4, 7, 1]],
        9: [[1, 2, 4, 7, 8, 10, 2]],
        10: [[*cube, 5], [*(np.array(CELLS[1]) + 1), 6]],
        49: [[*cube[:4], 7, 1]],
    }
    names = {5: "Edges", 6: "Triangles", 7: "Quadrilaterals", 8: "Tetrahedra", 9: "Prisms"}
    names |= {10: "Hexahedra", 49: "Pyramids"}
    if path.suffix == ".mesh":
        lines = [f"MeshVersionFormatted {version}", "# a comment, Vertices 3", "Dimension", "3"]
        rows = [f"{x!r} {y!r} {z!r}  {k}" for k, (x, y, z) in enumerate(POINTS.tolist())]
        lines += ["Vertices", "12", *rows]
        for code, own in parts.items():
            lines += [names[code], str(len(own)), *(" ".join(map(str, row)) for row in own)]
        path.write_text("\n".join([*lines, "Corners", "1", "1", "End", ""]))
        return
    real, place = ("f4" if version == 1 else "f8"), ("i4" if version < 3 else "i8")
    whole = "i8" if version == 4 else "i4"
    out = np.array([1, version], "<i4").tobytes()

    def section(code: int, body: bytes) -> bytes:
        end = len(out) + 4 + int(place[1]) + len(body)
        return np.array([code], "<i4").tobytes() + np.array([end], f"<{place}").tobytes() + body

    out += section(3, np.array([3], "<i4").tobytes())
    record = np.zeros(12, [("x", f"<{real}", 3), ("r", f"<{whole}")])
    record["x"] = POINTS
    out += section(4, np.array([12], f"<{whole}").tobytes() + record.tobytes())
    for code, rows in parts.items():
        body = np.array([len(rows)], f"<{whole}").tobytes() + np.array(rows, f"<{whole}").tobytes()
        out += section(code, body)
    out += np.array([54], "<i4").tobytes() + np.array([0], f"<{place}").tobytes()
    path.write_bytes(out)


def off(path: Path, keyword: str = "OFF") -> None:
    tail = " 0 0 1" if "N" in keyword else ""
    rows = "".join(f"{x!r} {y!r}\t{z!r}{tail}\n" for x, y, z in POINTS.tolist())
    path.write_text(f"{keyword}\n# counts\n12 3 0\n{rows}3 0 1 3\n4 1 2 5 4 255 0 0\n3 6 7 9\n")


def blocks(path: Path) -> None:
    """Two named parts beside the file, one of them inside a group."""
    import pyvista as pv

    box = pv.UnstructuredGrid(
        np.hstack([[8, *cell] for cell in CELLS]), [12, 12], np.array(POINTS, dtype=float)
    )
    skin = box.extract_surface(algorithm="dataset_surface")
    skin.points = skin.points.astype(float) + 10
    pv.MultiBlock({"air": box, "walls": pv.MultiBlock({"wing": skin})}).save(path)


def pieces(path: Path) -> None:
    """Two pieces of a grid beside the file."""
    import pyvista as pv

    names = []
    for k in range(2):
        cell = CELLS[k]
        grid = pv.UnstructuredGrid(np.array([8, *range(8)]), [12], POINTS[cell])
        names.append(f"{path.stem}_{k}.vtu")
        grid.save(path.with_name(names[-1]))
    listed = "".join(f'<Piece Source="{name}"/>' for name in names)
    path.write_text(
        '<?xml version="1.0"?>\n<VTKFile type="PUnstructuredGrid" version="0.1">\n'
        '<PUnstructuredGrid GhostLevel="0"><PPoints><PDataArray type="Float64" Name="Points" '
        f'NumberOfComponents="3"/></PPoints>{listed}</PUnstructuredGrid></VTKFile>\n'
    )
