"""Writing another format than the mesh's own: what arrives, what is lost, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import Mesh, MeshWarning, losses
from tests.meshes.oracles import with_meshio, with_vtk
from tests.meshes.specimens import SPECIMENS

pytestmark = pytest.mark.filterwarnings("ignore::ffdstudio.meshes.MeshWarning")


@pytest.fixture
def block(tmp_path) -> Mesh:
    SPECIMENS["plain.cgns"](tmp_path / "block.cgns")
    return read_mesh(tmp_path / "block.cgns")


def converted(mesh, target):
    with pytest.warns(MeshWarning, match="a new file is made"):
        write_mesh(mesh, target)
    return read_mesh(target)


def test_su2_takes_cells_and_boundaries_of_any_mesh(block, tmp_path):
    again = converted(block, tmp_path / "a.su2")
    assert np.array_equal(again.points, block.points)
    assert np.array_equal(again.cells["hexahedron"], block.cells["hexahedron"])
    assert np.array_equal(again.markers["hull"]["quad"], block.markers["hull"]["quad"])
    assert np.array_equal(with_meshio(tmp_path / "a.su2"), block.points)


@pytest.mark.parametrize("suffix", [".vtk", ".vtu", ".msh", ".inp"])
def test_volume_formats_take_all_cells(block, tmp_path, suffix):
    again = converted(block, tmp_path / f"a{suffix}")
    assert np.allclose(again.points, block.points, rtol=1e-15, atol=0)
    assert np.array_equal(again.cells["hexahedron"], block.cells["hexahedron"])


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply"])
def test_surface_formats_take_the_closed_skin(block, tmp_path, suffix):
    with pytest.warns(MeshWarning, match="12 volume cells are lost"):
        write_mesh(block, tmp_path / f"a{suffix}")
    skin = read_mesh(tmp_path / f"a{suffix}").surface()
    edges = [
        np.roll(nodes, -k, axis=1)[:, :2] for nodes in skin.values() for k in range(nodes.shape[1])
    ]
    edges = np.concatenate(edges)
    there, back = ({tuple(edge) for edge in part.tolist()} for part in (edges, edges[:, ::-1]))
    assert there == back
    assert len(with_vtk(tmp_path / f"a{suffix}")) > 0


def test_losses_are_listed_before_writing(block, tmp_path):
    assert losses(block, tmp_path / "b.cgns") == []
    assert losses(block, "b.su2") == [
        "a new file is made: comments, numbering and settings of the original are lost"
    ]
    assert losses(block, "b.stl")[1:] == [
        "only the surface is written, 12 volume cells are lost",
        "coordinates are rounded to single precision (float32)",
        "these markers are lost: hull, Low",
    ]


def test_what_cannot_be_made_is_refused_with_what_can(block, tmp_path):
    with pytest.raises(InputError, match=r"can be written as \.su2, \.stl.*not '\.bdf'"):
        write_mesh(block, tmp_path / "a.bdf")
    second = Mesh(np.zeros((10, 3)), {"tetra10": [list(range(10))]})
    with pytest.raises(InputError, match="SU2 cannot hold this mesh: it has tetra10"):
        write_mesh(second, tmp_path / "a.su2")
    assert list(tmp_path.glob("a.*")) == []


def test_a_name_that_would_lie_about_the_byte_order_is_refused(tmp_path):
    SPECIMENS["a.b8.ugrid"](tmp_path / "a.b8.ugrid")
    mesh = read_mesh(tmp_path / "a.b8.ugrid")
    write_mesh(mesh, tmp_path / "out.b8.ugrid")
    for name in ("out.ugrid", "out.lb8.ugrid"):
        with pytest.raises(InputError, match="of another format can be written as"):
            write_mesh(mesh, tmp_path / name)
