"""What users call their boundaries, and messages that say what to open."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
from tests.meshes.everyday_specimens import POINTS
from tests.meshes.specimens import SPECIMENS
from tests.meshes.test_openfoam import HEADER, block, make


def made(folder, name):
    SPECIMENS[name](folder / name)
    return read_mesh(folder / name)


@pytest.mark.parametrize("name", ["wide.lb8l.ugrid", "wide.b8l.ugrid"])
def test_boundaries_of_ugrid_have_the_names_of_the_mapbc_file(tmp_path, name):
    mesh = made(tmp_path, name)
    assert mesh.marker_counts == {"Fl\xfcgel": 1, "far field": 1}
    assert mesh.kinds == {"Fl\xfcgel": "wall", "far field": "farfield"}
    (tmp_path / "wide.mapbc").unlink()
    assert read_mesh(tmp_path / name).marker_counts == {"boundary 1": 1, "boundary 2": 1}


def test_materials_of_obj_are_markers_beside_its_groups(tmp_path):
    mesh = made(tmp_path, "mark.obj")
    assert mesh.counts == {"line": 1, "triangle": 1, "quad": 1}
    assert mesh.marker_counts == {"skin upper": 1, "window": 2, "metal": 1, "glass": 2}


def test_names_in_western_letters_are_read_as_such(tmp_path):
    text = "NDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n0 0\n1 0\n0 1\nNMARK= 1\n"
    text += "MARKER_TAG= fl\xfcgel\nMARKER_ELEMS= 1\n3 0 1\n"
    for encoding in ("utf-8", "latin-1"):
        (tmp_path / "a.su2").write_bytes(text.encode(encoding))
        assert list(read_mesh(tmp_path / "a.su2").markers) == ["fl\xfcgel"]


def test_cells_of_everyday_files_are_all_there(tmp_path):
    for name in ("mark.su2", "repeats.xyz", "plain.g", "plain.grd", "wide.lb8l.ugrid"):
        assert made(tmp_path, name).counts["hexahedron"] == 2
    assert made(tmp_path, "records.x").counts == {"hexahedron": 4}
    assert made(tmp_path, "plane.p2dfmt").counts == {"quad": 2}
    assert made(tmp_path, "scalar_first.ply").counts == {"triangle": 2, "quad": 1}
    assert made(tmp_path, "zero.stl").counts == {"triangle": 2}


@pytest.mark.parametrize(
    "text", ["1\n2 1 1\n0*1. 2. 3.\n", "1\n2 1 1\nx*1. 2.\n", "1\n9*9*9 1 1\n"]
)
def test_repeats_that_are_none_are_refused(tmp_path, text):
    (tmp_path / "a.xyz").write_text(f"1\n{text}")
    with pytest.raises(InputError, match=r"a\.xyz"):
        read_mesh(tmp_path / "a.xyz")


def test_repeats_of_a_number_larger_than_any_mesh_are_refused(tmp_path):
    (tmp_path / "a.xyz").write_text("1\n100000 100000 1\n10000000000*1. 1 1\n")
    with pytest.raises(InputError, match="repeated more often"):
        read_mesh(tmp_path / "a.xyz")


@pytest.mark.parametrize("label", ["<i4", "<i8"])
def test_faces_of_a_binary_face_list_are_read_and_damage_is_refused(tmp_path, label):
    arch = (int(label[2]), 8)
    case = make(tmp_path / "case", arch)
    plain = read_mesh(case)
    faces = block()[1]
    lists = b"".join(
        b"\n%d\n(" % len(face) + np.array(face, label).tobytes() + b")" for face in faces
    )
    arch_line = f'arch "LSB;label={8 * arch[0]};scalar=64";'
    head = HEADER.format(form="binary", arch=arch_line, kind="faceList", name="faces")
    file = case / "constant" / "polyMesh" / "faces"
    file.write_bytes(head.encode() + b"%d\n(" % len(faces) + lists + b"\n)\n")
    mesh = read_mesh(case)
    assert mesh.marker_counts == plain.marker_counts
    assert np.array_equal(mesh.faces.nodes, plain.faces.nodes)
    file.write_bytes(file.read_bytes()[:-60])
    with pytest.raises(InputError, match="ends before its"):
        read_mesh(case)


def test_a_case_of_regions_names_them(tmp_path):
    for region in ("fluid", "solid"):
        make(tmp_path / region)
        target = tmp_path / "case" / "constant" / region
        shutil.copytree(tmp_path / region / "constant", target)
    with pytest.raises(InputError, match=r"open .*fluid/polyMesh or .*solid/polyMesh"):
        read_mesh(tmp_path / "case")
    assert read_mesh(tmp_path / "case" / "constant" / "fluid" / "polyMesh").counts
    shutil.copytree(
        tmp_path / "fluid" / "constant" / "polyMesh", tmp_path / "case/constant/polyMesh"
    )
    with pytest.warns(MeshWarning, match="regions fluid, solid have meshes of their own"):
        read_mesh(tmp_path / "case")


def test_points_in_time_folders_are_told_and_a_file_of_the_mesh_opens_it(tmp_path):
    case = make(tmp_path / "case")
    for name in ("points", "boundary", "faces"):
        mesh = read_mesh(case / "constant" / "polyMesh" / name)
        assert mesh.format == "openfoam"
    assert len(read_mesh(case / "constant").points) == len(mesh.points)
    (case / "0.5" / "polyMesh").mkdir(parents=True)
    shutil.copy(case / "constant" / "polyMesh" / "points", case / "0.5" / "polyMesh")
    with pytest.warns(MeshWarning, match=r"time folders 0\.5; those in constant are opened"):
        read_mesh(case)


def test_a_format_that_can_only_be_read_says_so_at_once(tmp_path):
    import meshio

    meshio.write_points_cells(tmp_path / "a.xdmf", POINTS, [("triangle", [[0, 1, 3]])])
    with pytest.warns(MeshWarning, match="can only be read"):
        read_mesh(tmp_path / "a.xdmf")


def test_a_mark_stays_at_the_begin_whatever_moves(tmp_path):
    mesh = made(tmp_path, "mark.su2")
    write_mesh(mesh, tmp_path / "b.su2", mesh.points + 1)
    data = (tmp_path / "b.su2").read_bytes()
    assert data.startswith(b"\xef\xbb\xbfNDIME=")
    assert data.count(b"\xef\xbb\xbf") == 1
