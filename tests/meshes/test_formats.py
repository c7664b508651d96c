"""One table of formats and files: bytes kept at rest, and exact coordinates after a morph.

For every row: (1) at rest the file is written with the same bytes through the patching path;
(2) moving one node changes that node's lines (text) or bytes (binary) and nothing else;
(3) after a morph of all nodes an independent reader finds exactly the intended doubles,
rounded to the file's own type where that is float32.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from ffdstudio import read_mesh, write_mesh
from ffdstudio.meshes import Mesh, MeshWarning
from ffdstudio.meshes.formats.patch import TextTemplate
from tests.meshes import oracles
from tests.meshes.specimens import SPECIMENS


class Row(NamedTuple):
    """A file (made here, or real: ``folder/name`` in shared/meshes) and how to check it.

    `budget` is the number of lines (text) or bytes (binary) that one node may change;
    None where compression spreads a change. `digits` are those that a field has room for, where
    these are fewer than a double has.
    """

    file: str
    oracle: Callable[[Path], np.ndarray]
    text: bool = True
    budget: int | None = 1
    single: bool = False
    digits: int | None = None


TABLE = [
    Row("surface/oneram6_surface_flow.stl", oracles.by_words("vertex"), budget=30),
    Row("ascii.stl", oracles.by_words("vertex"), budget=30),
    Row("binary.stl", oracles.binary_stl, text=False, budget=24 * 12, single=True),
    Row("surface/wing_5degrees.obj", oracles.with_meshio),
    Row("mark.su2", oracles.su2_zones),
    Row("mark.obj", oracles.by_words("v")),
    Row("repeats.xyz", oracles.everyday_text, budget=3),
    Row("records.x", oracles.everyday_records, text=False, budget=24),
    Row("plane.p2dfmt", oracles.everyday_text, budget=3),
    Row("plain.grd", oracles.everyday_text, budget=3),
    Row("plain.g", oracles.everyday_text, budget=3),
    Row("wide.lb8l.ugrid", oracles.ugrid_wide, text=False, budget=24),
    Row("wide.b8l.ugrid", oracles.ugrid_wide, text=False, budget=24),
    Row("scalar_first.ply", oracles.ply_text),
    Row("blank_line.vtk", oracles.with_vtk),
    Row("lz4.vtu", oracles.with_vtk, text=False, budget=None),
    Row("lzma.vtu", oracles.with_vtk, text=False, budget=None),
    Row("zero.stl", oracles.binary_stl, text=False, budget=60, single=True),
    Row("most.stl", oracles.binary_stl, text=False, budget=60, single=True),
    Row("text.mesh", oracles.with_meshio),
    Row("binary.meshb", oracles.with_meshio, text=False, budget=24),
    Row("single.meshb", oracles.with_meshio, text=False, budget=12, single=True),
    Row("long.meshb", oracles.with_meshio, text=False, budget=24),
    Row("plain.off", oracles.off_text),
    Row("normals.off", oracles.off_text),
    Row("box.unv", oracles.unv_nodes),
    Row("quadratic.unv", oracles.unv_nodes),
    Row("box.med", oracles.med_nodes, text=False, budget=24),
    Row("quadratic.med", oracles.med_nodes, text=False, budget=24),
    Row("block.obj", oracles.by_words("v")),
    Row("ascii.ply", oracles.with_meshio, single=True),
    Row("binary.ply", oracles.with_meshio, text=False, budget=12, single=True),
    Row("double.ply", oracles.with_meshio, text=False, budget=24),
    Row("old.vtk", oracles.with_vtk),
    Row("old_binary.vtk", oracles.with_vtk, text=False, budget=24),
    Row("new.vtk", oracles.with_vtk),
    Row("new_binary.vtk", oracles.with_vtk, text=False, budget=24),
    Row("vtu/can.vtu", oracles.with_vtk, text=False, budget=12, single=True),
    Row("ascii.vtu", oracles.with_vtk),
    Row("inline.vtu", oracles.with_vtk, text=False, budget=36),
    Row("inline_packed.vtu", oracles.with_vtk, text=False, budget=None),
    Row("appended.vtu", oracles.with_vtk, text=False, budget=36),
    Row("appended_packed.vtu", oracles.with_vtk, text=False, budget=None),
    Row("raw.vtu", oracles.with_vtk, text=False, budget=24),
    Row("raw_packed.vtu", oracles.with_vtk, text=False, budget=None),
    Row("single.vtu", oracles.with_vtk, text=False, budget=12, single=True),
    Row("gmsh/of_CubeVer1.msh", oracles.with_gmsh),
    Row("gmsh/pyfr_inc-cylinder.msh", oracles.with_gmsh),
    Row("wing/oneram6_tets_22_binary.msh", oracles.with_gmsh, text=False, budget=24),
    Row("wing/oneram6_tets_41_ascii.msh", oracles.with_gmsh),
    Row("fluent/elbow.msh", oracles.fluent_nodes),
    Row("block_fluent.msh", oracles.fluent_nodes),
    Row("sector_fluent.msh", oracles.fluent_nodes),
    Row("sector_double.cas", oracles.fluent_binary, text=False, budget=24),
    Row("sector_single.msh", oracles.fluent_binary, text=False, budget=12, single=True),
    Row("sector.cas.h5", oracles.fluent_hdf, text=False, budget=24),
    Row("zones.msh.h5", oracles.fluent_hdf, text=False, budget=24),
    Row("packed.cas.h5", oracles.fluent_hdf, text=False, budget=None),
    Row("sector_mixed.cas", oracles.fluent_binary, text=False, budget=24),
    Row("abaqus/ccx_segmenttet.inp", oracles.with_meshio),
    Row("abaqus/avs_ucd_cellsnd.ascii.inp", oracles.avs_nodes),
    Row("a.text.ugrid", oracles.ugrid_text),
    Row("a.b8.ugrid", oracles.with_meshio, text=False, budget=24),
    Row("a.lb8.ugrid", oracles.with_meshio, text=False, budget=24),
    Row("a.b4.ugrid", oracles.with_meshio, text=False, budget=12, single=True),
    Row("a.lr8.ugrid", oracles.ugrid_records("<f8"), text=False, budget=24),
    Row("a.r4.ugrid", oracles.ugrid_records(">f4"), text=False, budget=12, single=True),
    Row("plot3d/dpw4FFD.xyz", oracles.plot3d_text, budget=3),
    Row("plot3d/oneram6_wingFFD.xyz", oracles.plot3d_text, budget=3),
    Row("plot3d/rae2822_wingFFD.xyz", oracles.plot3d_text, budget=3),
    Row("text.xyz", oracles.plot3d_text, budget=3),
    Row("text_blank.xyz", oracles.plot3d_text, budget=3),
    Row("text_single.xyz", oracles.plot3d_text, budget=3),
    Row("little.xyz", oracles.plot3d_binary, text=False, budget=24),
    Row("big_single.xyz", oracles.plot3d_binary, text=False, budget=24),
    Row("little_float.xyz", oracles.plot3d_binary, text=False, budget=12, single=True),
    Row("big_fortran.xyz", oracles.plot3d_binary, text=False, budget=24),
    Row("little_fortran_blank.xyz", oracles.plot3d_binary, text=False, budget=24),
    Row("little_fortran_single.xyz", oracles.plot3d_binary, text=False, budget=24),
    Row("cgns/717_wl_L2.cgns", oracles.cgns_with_vtk, text=False, budget=24),
    Row("cgns/mesh_bend_coarse.cgns", oracles.cgns_with_vtk, text=False, budget=24),
    Row("plain.cgns", oracles.cgns_with_h5py, text=False, budget=24),
    Row("adf_a.cgns", oracles.cgns_with_vtk, text=False, budget=24),
    Row("adf_b.cgns", oracles.cgns_with_vtk, text=False, budget=24),
    Row("adf_b_big.cgns", oracles.cgns_with_vtk, text=False, budget=24),
    Row("packed.cgns", oracles.cgns_with_h5py, text=False, budget=None),
    Row("exodus/mesh_fs8.exo", oracles.exodus_with_netcdf, text=False, budget=24),
    Row("classic.exo", oracles.exodus_with_netcdf, text=False, budget=24),
    Row("wide.exo", oracles.exodus_with_netcdf, text=False, budget=24),
    Row("hdf5.exo", oracles.exodus_with_netcdf, text=False, budget=24),
    Row("packed.exo", oracles.exodus_with_netcdf, text=False, budget=None),
    Row("v1.msh", oracles.with_gmsh),
    Row("v22.msh", oracles.with_gmsh),
    Row("v22_binary.msh", oracles.with_gmsh, text=False, budget=24),
    Row("v40.msh", oracles.with_gmsh),
    Row("v40_parametric.msh", oracles.with_gmsh),
    Row("v40_binary.msh", oracles.with_meshio, text=False, budget=24),
    Row("v41_periodic.msh", oracles.with_meshio),
    Row("v41_periodic_binary.msh", oracles.with_meshio, text=False, budget=24),
    Row("v41.msh", oracles.with_gmsh),
    Row("v41_parametric.msh", oracles.with_gmsh),
    Row("v41_binary.msh", oracles.with_gmsh, text=False, budget=24),
    Row("v41_binary_parametric.msh", oracles.with_gmsh, text=False, budget=24),
    Row("v22_two_groups.msh", oracles.with_gmsh),
    Row("v22_two_groups_binary.msh", oracles.with_gmsh, text=False, budget=24),
    Row("v41_partitioned.msh", oracles.with_gmsh),
    Row("v41_partitioned_binary.msh", oracles.with_gmsh, text=False, budget=24),
    Row("comments.bdf", oracles.nastran_large, budget=4, digits=13),
    Row("blanks.inp", oracles.abaqus_nodes),
    Row("zones_with_boxes.su2", oracles.su2_zones),
]


@pytest.fixture(params=TABLE, ids=lambda row: row.file.replace("/", "-"))
def case(request, tmp_path_factory, root) -> tuple[Row, Path, Mesh]:
    row = request.param
    if row.file in SPECIMENS:
        path = tmp_path_factory.mktemp("made") / row.file
        SPECIMENS[row.file](path)
    else:
        path = request.getfixturevalue("shared") / "meshes" / row.file
    return row, path, read_mesh(path)


def written(mesh: Mesh, target: Path, points: np.ndarray) -> bytes:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        write_mesh(mesh, target, points)
    return target.read_bytes()


def test_at_rest_a_file_keeps_its_bytes_through_the_patching_path(case, tmp_path):
    _, path, mesh = case
    assert mesh.template is not None
    assert written(mesh, tmp_path / path.name, mesh.points.copy()) == path.read_bytes()


def test_moving_one_node_changes_only_that_nodes_bytes(case, tmp_path):
    row, path, mesh = case
    points = mesh.points.copy()
    node = np.random.default_rng(7).integers(len(points))
    axes = mesh.dimension
    points[node, :axes] += [0.37, -0.21, 0.13][:axes]
    old, new = path.read_bytes(), written(mesh, tmp_path / path.name, points)
    if row.text:
        pairs = zip(old.split(b"\n"), new.split(b"\n"), strict=True)
        different = sum(a != b for a, b in pairs)
    elif row.budget is not None:
        assert len(old) == len(new)
        different = int((np.frombuffer(old, "u1") != np.frombuffer(new, "u1")).sum())
    again = read_mesh(tmp_path / path.name)
    others = np.delete(np.arange(len(points)), node)
    if len(again.points) == len(points):
        assert np.array_equal(again.points[others], mesh.points[others])
    assert again.counts == mesh.counts
    assert again.markers.keys() == mesh.markers.keys()
    if row.budget is not None:
        assert 0 < different <= row.budget


def test_after_a_morph_another_reader_finds_the_intended_coordinates(case, tmp_path):
    row, path, mesh = case
    rng = np.random.default_rng(3)
    points = mesh.points.copy()
    axes = mesh.dimension
    points[:, :axes] += rng.normal(0, 0.01 * np.ptp(points) + 1e-3, (len(points), axes))
    written(mesh, tmp_path / path.name, points)
    found = row.oracle(tmp_path / path.name).astype(np.float64)
    slots = getattr(mesh.template, "slots", None)
    expected = points if slots is None else points[slots]
    if row.single:
        expected = expected.astype(np.float32).astype(np.float64)
    if isinstance(mesh.template, TextTemplate) and mesh.template.width:
        assert np.allclose(found, expected, rtol=1e-12, atol=0)
    elif row.digits:
        assert np.abs(found - expected).max() < 10.0**-row.digits * np.abs(expected).max()
    else:
        assert np.array_equal(found, expected)


@pytest.mark.parametrize(
    "case", [row for row in TABLE if row.single], ids=lambda row: row.file, indirect=True
)
@pytest.mark.filterwarnings("ignore:.*normals")
def test_a_file_of_single_precision_says_that_it_rounds(case, tmp_path):
    _, path, mesh = case
    with pytest.warns(MeshWarning, match="single precision"):
        write_mesh(mesh, tmp_path / path.name, mesh.points + 0.1)
