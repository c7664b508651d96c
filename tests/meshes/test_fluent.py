"""Fluent: faces become cells with the right side out, and damage is named."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.pairs import pairs_of
from tests.meshes.fluent_specimens import ANGLE, AXIS, fluent_hdf
from tests.meshes.specimens import SPECIMENS


@pytest.fixture
def block(tmp_path):
    SPECIMENS["block_fluent.msh"](tmp_path / "block.msh")
    return tmp_path / "block.msh"


def test_normals_of_boundary_faces_point_out_of_the_block(block):
    mesh = read_mesh(block)
    assert mesh.counts == {"hexahedron": 12}
    assert mesh.kinds == {"outside": "wall"}
    quads = mesh.markers["outside"]["quad"]
    corners = mesh.points[quads]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    # the divergence theorem: the flux of x through the closed surface is three times the volume
    volume = (corners.mean(axis=1) * normal).sum() / 6
    assert volume == pytest.approx(3 * 2 / 3 * 2 / 7, rel=0.05)


def test_a_plane_mesh_has_anticlockwise_cells_of_the_whole_area(shared):
    mesh = read_mesh(shared / "meshes" / "fluent" / "elbow.msh")
    assert mesh.counts == {"triangle": 918}
    x, y, _ = mesh.points[mesh.cells["triangle"]].transpose(2, 0, 1)
    area = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1) / 2
    assert (area > 0).all()
    lines = np.concatenate([cells["line"] for cells in mesh.markers.values()])
    (ax, ay), (bx, by) = mesh.points[lines[:, 0], :2].T, mesh.points[lines[:, 1], :2].T
    assert abs((ax * by - ay * bx).sum() / 2) == pytest.approx(area.sum(), rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ("(2 3)", "(2 4)", "line 2: the dimension must be 2 or 3"),
        ("(10 (8 b", "(10 (8 c", "do not follow those before"),
        ("\n0.0 ", "\nnan ", "a number is not finite"),
        ("(45 (4 wall outside)", "(2010 (4 1 2 1 3)(", "a binary section does not end"),
        ("\n4 ", "\n5 ", "faces announced"),
        ("(45 (4 wall outside)())", "(45 (4 wall outside)()", "a section does not end"),
        (" 0 1\n", " 0 0\n", "a face without cells"),
        (" 0 1\n", " 0 fff\n", "cannot be there"),
        (" 0 1\n", " 0 g\n", "not a hexadecimal number"),
    ],
)
def test_damage_is_refused_with_place_and_cause(block, old, new, cause):
    text = block.read_text()
    assert old in text
    block.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=cause):
        read_mesh(block)


SECTORS = ["sector_fluent.msh", "sector_double.cas", "sector_single.msh", "sector_mixed.cas"]
HDF = ["sector.cas.h5", "zones.msh.h5", "packed.cas.h5"]


@pytest.mark.parametrize("name", [*SECTORS, *HDF])
def test_a_periodic_zone_and_its_shadow_are_partners_about_any_axis(tmp_path, name):
    SPECIMENS[name](tmp_path / name)
    mesh = read_mesh(tmp_path / name)
    assert mesh.counts == {"hexahedron": 12}
    assert mesh.partners == {"low": "high"}
    assert mesh.kinds == {"low": "periodic", "high": "periodic", "hull": "wall"}
    [pair] = pairs_of(mesh)
    assert pair.names == ("low", "high")
    assert len(pair.first) == 12
    assert (np.trace(pair.turn) - 1) / 2 == pytest.approx(np.cos(ANGLE), abs=1e-6)
    assert pair.turn @ AXIS == pytest.approx(AXIS, abs=1e-6)
    moved = mesh.points.copy()
    moved[mesh.marker_nodes("high")] += AXIS
    assert broken(mesh, mesh.points + AXIS) == []
    assert len(broken(mesh, moved)) == 1


def test_shadow_zones_without_their_pairs_are_periodic_too(tmp_path):
    path = tmp_path / "a.msh"
    SPECIMENS["sector_fluent.msh"](path)
    text = path.read_text()
    text = text[: text.index("(18 ")]
    path.write_text(text)  # neither pairs nor names: the types of the zones tell
    assert read_mesh(path).kinds == {"zone 4": "periodic", "zone 5": "periodic", "zone 6": "wall"}


@pytest.mark.parametrize("name", ["sector_double.cas", "sector_mixed.cas"])
def test_vtk_finds_the_same_cells_in_binary_sections(tmp_path, name):
    import vtk

    SPECIMENS[name](tmp_path / name)
    reader = vtk.vtkFLUENTReader()
    reader.SetFileName(str(tmp_path / name))
    reader.Update()
    grid = reader.GetOutput().GetBlock(0)
    assert grid.GetNumberOfCells() == 12
    assert grid.GetNumberOfPoints() == len(read_mesh(tmp_path / name).points)


def test_faces_of_eight_byte_numbers_are_understood(tmp_path):
    path = tmp_path / "a.cas"
    SPECIMENS["sector_double.cas"](path)
    data = path.read_bytes()
    parts = data.split(b"(3013 (")
    wide = [parts[0]]
    for part in parts[1:]:
        head, rest = part.split(b")(", 1)
        raw, rest = rest.split(b")\nEnd of Binary Section   3013)", 1)
        numbers = np.frombuffer(raw, "<i4").astype("<i8").tobytes()
        wide.append(head + b")(" + numbers + b")\nEnd of Binary Section   3013)" + rest)
    path.write_bytes(b"(3013 (".join(wide))
    assert read_mesh(path).counts == {"hexahedron": 12}


@pytest.mark.parametrize(
    "comment",
    [
        r'(0 "size:(3 \"x\" 2")',
        '(0 "5" wide)',
        r'(37 ((case-config ((rp-3d? . #t) (name "it\"s (open")))))',
        r"(38 (mark #\( and #\"))",
    ],
)
def test_quotation_marks_in_comments_and_settings_end_no_section(block, comment):
    block.write_text(comment + "\n" + block.read_text())
    assert read_mesh(block).counts == {"hexahedron": 12}


def test_a_binary_section_that_is_too_short_is_refused(tmp_path):
    path = tmp_path / "a.cas"
    SPECIMENS["sector_double.cas"](path)
    path.write_bytes(path.read_bytes().replace(b"(1 1 24 1 3)(", b"(1 1 25 1 3)("))
    with pytest.raises(InputError, match=r"37 nodes announced|does not end"):
        read_mesh(path)


@pytest.mark.parametrize("name", HDF)
def test_vtk_finds_the_same_mesh_in_hdf5(tmp_path, name):
    import vtk

    SPECIMENS[name](tmp_path / name)
    mesh = read_mesh(tmp_path / name)
    write_mesh(mesh, tmp_path / f"moved_{name}", mesh.points + 1)
    reader = vtk.vtkFLUENTCFFReader()
    reader.SetFileName(str(tmp_path / f"moved_{name}"))
    reader.Update()
    grid = reader.GetOutput().GetBlock(0)
    assert grid.GetNumberOfCells() == 12
    found = np.array([grid.GetPoint(k) for k in range(grid.GetNumberOfPoints())])
    assert np.abs(found - mesh.points - 1).max() < 1e-6  # VTK keeps single precision


def test_zones_of_an_hdf5_mesh_without_names_have_numbers(tmp_path):
    fluent_hdf(tmp_path / "a.cas.h5", names=False)
    mesh = read_mesh(tmp_path / "a.cas.h5")
    assert mesh.kinds == {"zone 4": "periodic", "zone 5": "periodic", "zone 6": "wall"}


@pytest.mark.parametrize(
    ("path", "change", "cause"),
    [
        ("nodes/coords/1", None, "no nodes"),
        ("faces/nodes/1/nodes", lambda v: v + 100, "not in 1 to 36"),
        ("faces/nodes/1/nnodes", lambda v: v + 1, "do not add up"),
        ("faces/c0/1", lambda v: 0 * v, "a face without cells"),
        ("faces/c0/1", lambda v: v + 1000, "cannot be there"),
        ("faces/zoneTopology/maxId", lambda v: v + 99, "faces that are not there"),
        ("faces/zoneTopology/id", lambda v: v[:2], "damaged"),
        ("faces/zoneTopology", None, "there is no faces/zoneTopology"),
    ],
)
def test_damage_in_hdf5_is_refused_with_the_cause(tmp_path, path, change, cause):
    import h5py

    fluent_hdf(tmp_path / "a.cas.h5")
    with h5py.File(tmp_path / "a.cas.h5", "a") as file:
        item = file["meshes/1"][path]
        if change is None:
            del file["meshes/1"][path]
        else:
            values, attributes = change(item[()]), dict(item.attrs)
            del file["meshes/1"][path]
            new = file["meshes/1"].create_dataset(path, data=values)
            new.attrs.update(attributes)
    with pytest.raises(InputError, match=cause):
        read_mesh(tmp_path / "a.cas.h5")


def test_a_binary_face_of_a_negative_cell_is_refused(tmp_path):
    path = tmp_path / "a.cas"
    SPECIMENS["sector_double.cas"](path)
    data = bytearray(path.read_bytes())
    at = data.index(b"(3013 (")
    at = data.index(b")(", at) + 2
    data[at + 19] = 0x80  # the sign of the first cell beside the first face
    path.write_bytes(data)
    with pytest.raises(InputError, match="a face without cells"):
        read_mesh(path)
