"""Medit, MED, OFF, universal files, VTK's blocks and pieces: cells, names, damage."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
from tests.meshes import exchange_specimens as specimens
from tests.meshes.oracles import with_vtk


def volume(mesh, kind="tetra") -> float:
    """Sum of the signed volumes of tetrahedra."""
    a, b, c, d = (mesh.points[mesh.cells[kind][:, k]] for k in range(4))
    return float(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a).sum() / 6)


@pytest.mark.parametrize("name", ["a.unv", "a.med", "a.mesh"])
def test_cells_fill_the_box_and_groups_bear_their_names(tmp_path, name):
    specimens.by_gmsh(tmp_path / name)
    mesh = read_mesh(tmp_path / name)
    assert volume(mesh) == pytest.approx(1 / 21)
    names = {"wall", "fluid"} if name != "a.mesh" else {"surface 7", "volume 9"}
    assert names <= set(mesh.markers)
    wall = "surface 7" if name == "a.mesh" else "wall"
    fluid = "volume 9" if name == "a.mesh" else "fluid"
    assert mesh.marker_counts[fluid] == len(mesh.cells["tetra"])
    assert set(np.unique(mesh.points[mesh.marker_nodes(wall), 0])) <= {0.0, 1.0}


@pytest.mark.parametrize("name", ["a.unv", "a.med"])
def test_nodes_in_the_middle_of_edges_are_where_they_belong(tmp_path, name):
    specimens.by_gmsh(tmp_path / name, order=2)
    mesh = read_mesh(tmp_path / name)
    for kind, edges in (
        ("tetra10", [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]),
        ("triangle6", [(0, 1), (1, 2), (2, 0)]),
    ):
        nodes = mesh.cells[kind]
        corners = 4 if kind == "tetra10" else 3
        for k, (a, b) in enumerate(edges):
            middle = (mesh.points[nodes[:, a]] + mesh.points[nodes[:, b]]) / 2
            assert mesh.points[nodes[:, corners + k]] == pytest.approx(middle)


def test_a_plane_med_mesh_has_two_coordinates_or_three(tmp_path):
    specimens.by_gmsh(tmp_path / "a.med", plane=True)
    mesh = read_mesh(tmp_path / "a.med")
    assert set(mesh.counts) >= {"triangle", "line"}
    assert mesh.marker_counts["wall"] > 0


@pytest.mark.parametrize("name", ["a.mesh", "a.meshb"])
@pytest.mark.parametrize("version", [1, 2, 3, 4])
def test_all_cells_of_medit_have_their_references(tmp_path, name, version):
    specimens.medit(tmp_path / name, version)
    mesh = read_mesh(tmp_path / name)
    assert mesh.counts == {
        **{"line": 2, "triangle": 2, "quad": 1, "tetra": 1, "wedge": 1},
        **{"hexahedron": 2, "pyramid": 1},
    }
    assert mesh.marker_counts == {
        **{"edges 4": 1, "surface 3": 2, "volume 1": 2, "volume 2": 1},
        **{"volume 5": 1, "volume 6": 1},
    }


@pytest.mark.parametrize("keyword", ["OFF", "NOFF", "COFF", "CNOFF"])
def test_off_surfaces_may_hold_more_than_coordinates(tmp_path, keyword):
    specimens.off(tmp_path / "a.off", keyword)
    mesh = read_mesh(tmp_path / "a.off")
    assert mesh.counts == {"triangle": 2, "quad": 1}
    if "N" in keyword:
        with pytest.warns(MeshWarning, match="vertex normals"):
            write_mesh(mesh, tmp_path / "b.off", mesh.points + 1)


def test_any_surface_can_be_written_as_off(tmp_path):
    specimens.medit(tmp_path / "a.mesh")
    with pytest.warns(MeshWarning):
        write_mesh(read_mesh(tmp_path / "a.mesh"), tmp_path / "b.off")
    assert read_mesh(tmp_path / "b.off").counts.keys() >= {"triangle"}


@pytest.mark.parametrize(
    ("write", "name", "change", "cause"),
    [
        (specimens.off, "a.off", (b"12 3 0", b"13 3 0"), "13 vertices and 3 faces"),
        (specimens.off, "a.off", (b"3 6 7 9", b"3 6 7 99"), "not in 0 to 11"),
        (specimens.off, "a.off", (b"OFF", b"4OFF"), "three dimensions and as text"),
        (specimens.medit, "a.mesh", (b"Vertices\n12", b"Vertices\n11"), "11 Vertices of 4 numbers"),
        (specimens.medit, "a.mesh", (b"Dimension\n3", b"Dimension\n4"), "must be 2 or 3"),
        (specimens.medit, "a.mesh", (b"1 2 4 3\n", b"1 2 99 3\n"), "not in 1 to 12"),
        (specimens.medit, "a.meshb", (b"\2\0\0\0\3\0\0\0", b"\7\0\0\0\3\0\0\0"), "version 7"),
        (specimens.by_gmsh, "a.unv", (b"  2411\n", b"  2410\n"), "no dataset 2411"),
        (specimens.by_gmsh, "a.unv", (b"D+00", b"X+00"), "needs three coordinates"),
    ],
)
def test_damage_is_refused_with_its_cause(tmp_path, write, name, change, cause):
    write(tmp_path / name)
    data = (tmp_path / name).read_bytes()
    assert change[0] in data
    (tmp_path / name).write_bytes(data.replace(*change, 1))
    with pytest.raises(InputError, match=cause):
        read_mesh(tmp_path / name)


@pytest.mark.parametrize("name", ["a.meshb", "a.med", "a.unv"])
def test_truncated_files_are_refused(tmp_path, name):
    (specimens.medit if name == "a.meshb" else specimens.by_gmsh)(tmp_path / name)
    data = (tmp_path / name).read_bytes()
    for part in (0.1, 0.4):
        (tmp_path / name).write_bytes(data[: int(part * len(data))])
        with pytest.raises(InputError, match=name):
            read_mesh(tmp_path / name)


# ---- files that name others --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("write", "name"), [(specimens.blocks, "a.vtm"), (specimens.pieces, "a.pvtu")]
)
def test_parts_are_joined_and_written_beside_the_file(tmp_path, write, name):
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    write(tmp_path / "in" / name)
    mesh = read_mesh(tmp_path / "in" / name)
    assert mesh.counts["hexahedron"] == 2
    if name == "a.vtm":
        assert mesh.marker_counts == {"air": 2, "walls/wing": 10}
    points = mesh.points + [1 / 3, 0, 0] * (mesh.points[:, :1] < 5)
    with pytest.raises(InputError, match="would be overwritten"):
        write_mesh(mesh, tmp_path / "in" / f"other_{name}", points)
    write_mesh(mesh, tmp_path / "out" / name, points)
    assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "in" / name).read_bytes()
    assert np.array_equal(read_mesh(tmp_path / "out" / name).points, points)
    if name == "a.pvtu":
        found = with_vtk(tmp_path / "out" / name)
        assert {tuple(p) for p in found.tolist()} == {tuple(p) for p in points.tolist()}
    write_mesh(mesh, tmp_path / "out" / name, mesh.points.copy())
    names = [path.relative_to(tmp_path / "in") for path in (tmp_path / "in").rglob("*.vt*")]
    for own in names:
        assert (tmp_path / "out" / own).read_bytes() == (tmp_path / "in" / own).read_bytes()


@pytest.mark.parametrize("file", ["../a.vtu", "/etc/hostname", "C:\\a.vtu", "."])
def test_parts_outside_the_folder_are_refused(tmp_path, file):
    text = f'<VTKFile type="PUnstructuredGrid"><Piece Source="{file}"/></VTKFile>'
    (tmp_path / "a.pvtu").write_text(text)
    with pytest.raises(InputError, match="lies outside its folder"):
        read_mesh(tmp_path / "a.pvtu")


def test_a_part_that_is_not_there_is_named(tmp_path):
    (tmp_path / "a.pvtu").write_text('<VTKFile><Piece Source="gone.vtu"/></VTKFile>')
    with pytest.raises(InputError, match=r"gone\.vtu"):
        read_mesh(tmp_path / "a.pvtu")
