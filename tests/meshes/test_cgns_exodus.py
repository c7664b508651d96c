"""CGNS and Exodus: boundaries with their kinds, side sets, refusals, missing libraries."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh
from ffdstudio.meshes.formats.exodus import SIDES
from ffdstudio.meshes.topology import FACES
from tests.meshes.specimens import SPECIMENS


def made(folder, name):
    SPECIMENS[name](folder / name)
    return folder / name


def test_boundary_conditions_become_markers_with_their_kind(tmp_path, shared):
    mesh = read_mesh(made(tmp_path, "plain.cgns"))
    assert mesh.counts == {"hexahedron": 12}
    assert mesh.marker_counts == {"hull": 3}
    assert mesh.kinds == {"hull": "wall"}
    assert mesh.markers["hull"]["quad"].tolist() == mesh.cells["hexahedron"][:3, :4].tolist()
    wing = read_mesh(shared / "meshes" / "cgns" / "717_wl_L2.cgns")
    flat = wing.marker_nodes("domain.00001/BC3")
    assert wing.kinds["domain.00001/BC3"] == "symmetry"
    assert np.ptp(wing.points[flat], axis=0).min() < 1e-9


def test_cells_of_a_real_mixed_mesh_fill_its_boundary(shared):
    mesh = read_mesh(shared / "meshes" / "cgns" / "mesh_bend_coarse.cgns")
    faces = mesh.surface()
    boundary = sum(mesh.marker_counts.values())
    assert sum(map(len, faces.values())) == boundary
    key = {tuple(sorted(row)) for nodes in faces.values() for row in nodes.tolist()}
    for cells in mesh.markers.values():
        for nodes in cells.values():
            assert {tuple(sorted(row)) for row in nodes.tolist()} <= key


def test_side_sets_and_node_sets_become_markers(tmp_path):
    mesh = read_mesh(made(tmp_path, "classic.exo"))
    assert mesh.marker_counts == {"floor": 2, "node set 1": 3}
    assert (mesh.points[mesh.marker_nodes("floor"), 2] < 0.2).all()


@pytest.mark.parametrize("kind", FACES)
def test_sides_are_the_faces_of_their_cell_with_outward_normals(kind):
    def cyclic(face):
        first = face.index(min(face))
        return face[first:] + face[:first]

    assert {cyclic(face) for face in SIDES[kind]} == {cyclic(face) for face in FACES[kind]} or (
        kind == "wedge"  # VTK's wedge has its triangles the other way round
    )


@pytest.mark.parametrize("name", ["plain.cgns", "hdf5.exo"])
def test_a_missing_library_is_named_with_what_to_install(tmp_path, name, monkeypatch):
    path = made(tmp_path, name)
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match=r"needs h5py: pip install 'ffdstudio\[formats\]'"):
        read_mesh(path)


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        (b"CoordinateX", b"CoordinateR", "has coordinates .*not x, y, z"),
        (b"AdF2LL", b"AdF2CL", "neither big nor little end first"),
        (b"SNTb", b"XXXX", "damaged: no mark SNTb"),
        (b"01000004EB", b"01FFFFFFFF", "does not fit the file"),
    ],
)
def test_a_damaged_adf_file_is_refused(shared, tmp_path, old, new, cause):
    data = (shared / "meshes" / "cgns" / "mesh_bend_coarse.cgns").read_bytes()
    (tmp_path / "a.cgns").write_bytes(data.replace(old, new))
    with pytest.raises(InputError, match=cause):
        read_mesh(tmp_path / "a.cgns")


@pytest.mark.parametrize("name", ["plain.cgns", "classic.exo", "hdf5.exo"])
def test_truncated_files_are_refused(tmp_path, name):
    path = made(tmp_path, name)
    data = path.read_bytes()
    for part in (0.1, 0.5, 0.8):
        path.write_bytes(data[: int(part * len(data))])
        with pytest.raises(InputError, match=name):
            read_mesh(path)
