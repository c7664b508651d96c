"""The container: checks, helpers, the skin, and which file belongs to which format."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, quality, read_mesh, write_mesh
from ffdstudio.meshes import Faces, Mesh
from ffdstudio.meshes.formats import FORMATS, recognise
from tests.meshes.specimens import SPECIMENS, grid_points, hexahedra, hexahedron_faces, vtk_grid


def block() -> Mesh:
    cells = hexahedra()
    return Mesh(
        grid_points(),
        {"hexahedron": cells},
        {"low": {"quad": cells[:3, :4]}, "all": {"hexahedron": cells}},
    )


def test_points_and_cells_are_read_only_and_independent_of_the_callers_array():
    points = grid_points()
    mesh = Mesh(points, {"hexahedron": hexahedra()})
    points[0] = 99
    assert mesh.points[0, 0] != 99
    with pytest.raises(ValueError, match="read-only"):
        mesh.points[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        mesh.cells["hexahedron"][0] = 1


def test_the_skin_of_a_volume_is_what_vtk_extracts():
    faces = block().surface()["quad"]
    theirs = vtk_grid().extract_surface(algorithm="dataset_surface", pass_pointid=True)
    ids = theirs["vtkOriginalPointIds"]
    quads = theirs.faces.reshape(-1, 5)[:, 1:]
    assert {tuple(sorted(ids[quad])) for quad in quads} == {
        tuple(sorted(f)) for f in faces.tolist()
    }
    corners = block().points[faces]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    outward = corners.mean(axis=1) - block().points.mean(axis=0)
    assert (np.einsum("ij,ij->i", normal, outward) > 0).all()


def test_boundaries_are_the_markers_below_the_cells_dimension():
    mesh = block()
    assert mesh.boundaries == ["low"]
    assert np.array_equal(mesh.marker_nodes(), np.unique(hexahedra()[:3, :4]))
    assert len(mesh.marker_nodes("all")) == len(mesh.points)
    assert mesh.marker_counts == {"low": 3, "all": 12}
    with pytest.raises(InputError, match="no marker high in this mesh; it has: low, all"):
        mesh.marker_nodes("high")


def test_faces_tell_their_cells_apart():
    faces, owner, neighbour = hexahedron_faces()
    value = Faces(
        np.array(faces).ravel(), 4 * np.arange(len(faces) + 1), np.array(owner), np.array(neighbour)
    )
    mesh = Mesh(grid_points(), faces=value)
    assert mesh.counts == {"hexahedron": 12}
    assert len(mesh.surface()["quad"]) == len(block().surface()["quad"])
    wedge = [[0, 1, 2], [3, 5, 4], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]]
    sizes = [len(face) for face in wedge]
    alone = Faces(
        np.concatenate(wedge),
        np.concatenate([[0], np.cumsum(sizes)]),
        np.zeros(5, int),
        np.full(5, -1),
    )
    assert alone.counts == {"wedge": 1}


def test_with_points_keeps_all_but_the_coordinates():
    mesh = block()
    moved = mesh.with_points(mesh.points + 1)
    assert moved.cells["hexahedron"] is not None
    assert np.array_equal(moved.bounds, mesh.bounds + 1)
    with pytest.raises(InputError, match="36 nodes, the coordinates given are 35"):
        mesh.with_points(mesh.points[1:])


@pytest.mark.parametrize(
    ("points", "cells", "cause"),
    [
        (np.zeros((3, 2)), {}, r"array \(n, 3\), got \(3, 2\)"),
        (np.full((1, 3), np.inf), {}, "node 0 .* not a finite number"),
        (np.zeros((3, 3)), {"triangle": [[0, 1, 3]]}, "triangle 0 .* outside 0 to 2"),
        (np.zeros((3, 3)), {"triangle": [[0, 1, -1]]}, "triangle 0 .* outside 0 to 2"),
        (np.zeros((3, 3)), {"triangle": [0, 1, 2]}, r"array \(cells, nodes\)"),
    ],
)
def test_what_is_no_mesh_is_refused(points, cells, cause):
    with pytest.raises(InputError, match=cause):
        Mesh(points, cells)


def test_files_are_recognised_by_suffix_and_content(tmp_path):
    expected = {".stl": "stl", ".obj": "obj", ".ply": "ply", ".vtk": "vtk", ".vtu": "vtu"}
    expected |= {".cgns": "cgns", ".exo": "exodus", ".ugrid": "ugrid", ".xyz": "plot3d"}
    expected |= {".su2": "su2", ".bdf": "nastran", ".inp": "abaqus"}
    for name, write in SPECIMENS.items():
        write(tmp_path / name)
        row = recognise(tmp_path / name, (tmp_path / name).read_bytes()[:4096])
        if name.endswith(".msh"):
            assert row.name == ("gmsh" if name.startswith("v") else "fluent"), name
        else:
            wanted = expected.get((tmp_path / name).suffix)
            assert row.name == wanted or wanted is None
    assert len({row.title for row in FORMATS}) == len(FORMATS)


@pytest.mark.parametrize("data", [b"", b"noise \xff\x00" * 50, b"solid"])
@pytest.mark.parametrize(
    "suffix", sorted({s for row in FORMATS for s in row.suffixes} | {".zzz", ""})
)
def test_empty_files_and_noise_are_refused_whatever_their_name(tmp_path, suffix, data):
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(data)
    with pytest.raises(InputError, match="bad") as caught:
        read_mesh(path)
    assert "\n" not in str(caught.value)


def test_a_missing_file_and_a_folder_without_mesh_are_refused(tmp_path):
    with pytest.raises(InputError, match="cannot read"):
        read_mesh(tmp_path / "none.su2")
    with pytest.raises(InputError, match="there is no folder"):
        read_mesh(tmp_path)


@pytest.mark.parametrize(
    ("make", "cause"),
    [
        (lambda: Mesh("points"), "points must be an array of numbers"),
        (lambda: Mesh([[1], [1, 2]]), "points must be an array of numbers"),
        (lambda: Mesh([[0, 0, 1j]]), "points must be an array of numbers"),
        (lambda: Mesh([[0, 0, 0]], {"vertex": "abc"}), "the cells: vertex must be an array of"),
        (lambda: Mesh([[0, 0, 0]], {"vertex": [[0.5]]}), "must be an array of node indices"),
        (lambda: Mesh([[0, 0, 0]], {"vertex": [[np.nan]]}), "must be an array of node indices"),
        (lambda: Mesh([[0, 0, 0]], [[0]]), "the cells must be given by type"),
        (lambda: Mesh([[0, 0, 0]], {}, {"hull": [[0]]}), "marker hull must be given by type"),
        (lambda: Mesh([[0, 0, 0]], {}, [[0]]), "markers must be given by name"),
        (lambda: Mesh([[0, 0, 0]]).with_points("x"), "points must be an array of numbers"),
        (lambda: Mesh([[0, 0, 0]]).marker_nodes(["hull"]), r"no marker \['hull'\]"),
        (lambda: quality(Mesh([[0, 0, 0]]), "x"), "the points given must be an array of"),
        (lambda: quality("mesh"), "a mesh is needed, got 'mesh'"),
        (lambda: write_mesh("mesh", "a.su2"), "a mesh is needed, got 'mesh'"),
        (lambda: write_mesh(Mesh([[0, 0, 0]]), None), "a path must be"),
        (lambda: read_mesh(5), "a path must be"),
        (lambda: read_mesh("n" * 300), "file name too long"),
    ],
)
def test_whatever_is_wrong_with_an_argument_is_said_in_words(make, cause):
    with pytest.raises(InputError, match=cause):
        make()
