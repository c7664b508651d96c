"""CGNS and Exodus: boundaries with their kinds, side sets, refusals, missing libraries."""

from __future__ import annotations

import sys

import h5py
import netCDF4
import numpy as np
import pytest

from ffdstudio import InputError, read_mesh
from ffdstudio.meshes import MeshWarning
from ffdstudio.meshes.formats.cgns_boundaries import patch
from ffdstudio.meshes.formats.cgns_nodes import Node
from ffdstudio.meshes.formats.exodus import SIDES
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.topology import FACES
from tests.meshes.specimens import SPECIMENS


def made(folder, name):
    SPECIMENS[name](folder / name)
    return folder / name


def test_boundary_conditions_become_markers_with_their_kind(tmp_path, shared):
    mesh = read_mesh(made(tmp_path, "plain.cgns"))
    assert mesh.counts == {"hexahedron": 12}
    assert mesh.marker_counts == {"hull": 3, "Low": 12}
    assert mesh.kinds == {"hull": "wall"}
    assert mesh.markers["hull"]["quad"].tolist() == mesh.cells["hexahedron"][:3, :4].tolist()
    wing = read_mesh(shared / "meshes" / "cgns" / "717_wl_L2.cgns")
    flat = wing.marker_nodes("Sym")
    assert wing.kinds == {"wall": "wall", "Far": "farfield", "Sym": "symmetry"}
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


def edited(folder, **children):
    """A CGNS file whose boundary condition has other children and whose base has a family."""
    path = made(folder, "plain.cgns")

    def node(parent, name, label, data=None):
        group = parent.create_group(name)
        group.attrs["label"], group.attrs["name"] = np.bytes_(label), np.bytes_(name)
        if data is not None:
            values = np.frombuffer(data, np.int8) if isinstance(data, bytes) else np.array(data)
            group.create_dataset(" data", data=values)
        return group

    with h5py.File(path, "a") as file:
        condition = file["Base/Zone/ZoneBC/hull"]
        for name in list(condition):
            del condition[name]
        for name, data in children.items():
            node(condition, name, "FamilyName_t" if name == "FamilyName" else "any", data)
        condition[" data"] = np.frombuffer(b"FamilySpecified", np.int8)
        node(node(file["Base"], "Skin", "Family_t"), "Type", "FamilyBC_t", b"BCWallInviscid")
    return path


def test_a_boundary_of_vertices_gets_the_faces_between_them(tmp_path):
    mesh = read_mesh(edited(tmp_path, PointRange=[[1], [12]], FamilyName=b"/Base/Skin"))
    assert set(mesh.marker_nodes("Skin").tolist()) == set(range(12))
    assert mesh.marker_counts == {"Skin": 6, "Low": 12}
    assert mesh.kinds == {"Skin": "wall"}


def test_a_boundary_of_vertices_without_faces_keeps_the_vertices(tmp_path):
    mesh = read_mesh(edited(tmp_path, PointList=[[3], [1]], GridLocation=b"Vertex"))
    assert mesh.markers["hull"]["vertex"].tolist() == [[0], [2]]
    with pytest.raises(InputError, match="boundary hull refers to a node not in 1 to 36"):
        read_mesh(edited(tmp_path, PointList=[[1], [37]]))


def test_a_boundary_that_cannot_be_shown_is_named(tmp_path):
    with pytest.warns(MeshWarning, match="kept but not shown: hull"):
        read_mesh(edited(tmp_path, PointList=[[99]], GridLocation=b"FaceCenter"))


def test_zones_of_the_same_name_in_two_bases_are_told_apart(tmp_path):
    path = made(tmp_path, "plain.cgns")
    with h5py.File(path, "a") as file:
        file.copy("Base", "Other")
        file["Other"].attrs["name"] = np.bytes_("Other")
    mesh = read_mesh(path)
    assert mesh.marker_counts == {
        "Base/Zone": 12,
        "Base/Zone/hull": 3,
        "Base/Zone/Low": 12,
        "Other/Zone": 12,
        "Other/Zone/hull": 3,
        "Other/Zone/Low": 12,
    }
    nodes = [mesh.marker_nodes(f"{base}/Zone") for base in ("Base", "Other")]
    assert len(np.intersect1d(*nodes)) == 0


def structured(**children):
    def array(name, values):
        return Node(name, "any", data=np.array(values))

    text = {
        name: np.frombuffer(data, "S1") for name, data in children.items() if type(data) is bytes
    }
    return Node("wall", "BC_t", children=[array(k, text.get(k, v)) for k, v in children.items()])


@pytest.mark.parametrize(
    ("children", "nodes"),
    [
        ({"PointRange": [2, 1, 1, 2, 3, 2]}, [1, 5, 9, 13, 17, 21]),
        (
            {"PointRange": [2, 1, 1, 2, 2, 1], "GridLocation": b"IFaceCenter"},
            [1, 5, 9, 13, 17, 21],
        ),
        ({"PointList": [1, 1, 1, 4, 3, 2]}, [0, 23]),
    ],
)
def test_a_patch_of_a_block_counts_vertices_or_faces_as_it_says(tmp_path, children, nodes):
    source = Source(tmp_path / "a.cgns", b"")
    cells = patch(source, structured(**children), (4, 3, 2))
    assert np.unique(np.concatenate([found.ravel() for found in cells.values()])).tolist() == nodes


def test_blocks_and_sets_of_the_same_name_are_all_kept(tmp_path):
    path = made(tmp_path, "hdf5.exo")
    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("two", 2)
        for name, kind in (("elem_ss2", 3), ("side_ss2", 5)):
            file.createVariable(name, "i4", ("two",))[:] = [kind, kind]
        file.createDimension("num_node_sets", 1)
        names = file.createVariable("ns_names", "S1", ("num_node_sets", "len_string"))
        names[:] = netCDF4.stringtochar(np.array(["floor"], "S33"))
    mesh = read_mesh(path)
    assert mesh.marker_counts == {"floor": 2, "side set 2": 2, "floor (node set)": 3}


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


@pytest.mark.parametrize("name", ["ElementRange", "ElementConnectivity", " data"])
@pytest.mark.parametrize("values", [np.bytes_("text"), np.full(3, np.nan), np.zeros((2, 2))])
def test_a_section_with_texts_for_numbers_is_refused_in_a_sentence(tmp_path, name, values):
    path = made(tmp_path, "plain.cgns")
    with h5py.File(path, "r+") as file:
        found: list[str] = []
        file.visit(found.append)
        place = next(n for n in found if n.endswith("ElementRange/ data"))
        place = place.replace("ElementRange/ data", "" if name == " data" else f"{name}/") + " data"
        place = place.replace(" data data", " data")
        parent, _, own = place.rpartition("/")
        del file[parent][own]
        file[parent][own] = values
    with pytest.raises(InputError, match=r"plain\.cgns: "):
        read_mesh(path)
