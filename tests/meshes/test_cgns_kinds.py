"""CGNS: families, connections, rind planes, both forms of ADF, and version 3.0's numbers."""

from __future__ import annotations

import contextlib
import warnings

import h5py
import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.pairs import pairs_of
from tests.meshes.cgns_specimens import (
    SHAPE,
    Item,
    as_adf,
    as_hdf5,
    hexa_zone,
    ints,
    positions,
    structured,
    text,
    version,
)

FAMILIES = {"bc-1": "Blade Suction Side", "bc-2": "Hub"}


@pytest.mark.parametrize("write", [as_hdf5, as_adf])
def test_boundaries_bear_the_names_of_their_families(tmp_path, write):
    write(tmp_path / "a.cgns", hexa_zone(FAMILIES))
    mesh = read_mesh(tmp_path / "a.cgns")
    assert mesh.marker_counts == {"Blade Suction Side": 4, "Hub": 4}
    assert mesh.kinds == {"Blade Suction Side": "wall", "Hub": "wall"}


def test_conditions_of_one_family_are_one_boundary_and_paths_to_families_their_last_name(tmp_path):
    as_hdf5(tmp_path / "a.cgns", hexa_zone(dict.fromkeys(FAMILIES, "Skin")))
    assert read_mesh(tmp_path / "a.cgns").marker_counts == {"Skin": 8}
    as_hdf5(tmp_path / "b.cgns", hexa_zone({"bc-1": "Skin"}))
    with h5py.File(tmp_path / "b.cgns", "a") as file:
        condition = file["Base/Zone 1/ZoneBC/bc-1/FamilyName"]
        del condition[" data"]
        condition[" data"] = np.frombuffer(b"/Base/Skin", np.int8)
    assert read_mesh(tmp_path / "b.cgns").marker_counts == {"Skin": 4, "bc-2": 4}


def test_a_section_of_faces_that_no_condition_covers_is_a_boundary_too(tmp_path):
    as_hdf5(tmp_path / "a.cgns", hexa_zone())
    with h5py.File(tmp_path / "a.cgns", "a") as file:
        del file["Base/Zone 1/ZoneBC/bc-2"]
    assert read_mesh(tmp_path / "a.cgns").marker_counts == {"bc-1": 4, "high faces": 4}


def test_element_numbers_of_version_3_0_are_its_own(tmp_path):
    items = [version(3.0), *hexa_zone(shift=1)[1:]]
    as_hdf5(tmp_path / "a.cgns", items)
    assert read_mesh(tmp_path / "a.cgns").counts == {"hexahedron": 12}
    as_hdf5(tmp_path / "a.cgns", [version(3.1), *items[1:]])
    with pytest.raises(InputError, match="20"):  # as many nodes as HEXA_20 has are not there
        read_mesh(tmp_path / "a.cgns")


def test_mixed_elements_of_version_3_0_are_its_own(tmp_path):
    def items(number: float, types: tuple[int, int, int]) -> list[Item]:
        cube = [1, 2, 3, 4, 5, 6, 7, 8]
        flat = [types[0], *cube, types[1], 1, 2, 3, 4, 5]
        sections = (
            Item("ElementRange", "IndexRange_t", ints(1, 2)),
            Item("ElementConnectivity", "DataArray_t", ints(*flat)),
        )
        points = np.array([[0, 1, 1, 0] * 2, [0, 0, 1, 1] * 2, [0] * 4 + [1] * 4], float)
        arrays = [
            Item(f"Coordinate{axis}", "DataArray_t", row.copy())
            for axis, row in zip("XYZ", points, strict=True)
        ]
        children = (
            Item("ZoneType", "ZoneType_t", text("Unstructured")),
            Item("GridCoordinates", "GridCoordinates_t", None, tuple(arrays)),
            Item("Cells", "Elements_t", ints(types[2], 0), sections),
        )
        zone = Item("Zone", "Zone_t", np.array([[8], [2], [0]], np.int32), children)
        return [version(number), Item("Base", "CGNSBase_t", ints(3, 3), (zone,))]

    for number, types in ((3.0, (18, 12, 21)), (2.4, (17, 12, 20)), (4.2, (17, 12, 20))):
        as_hdf5(tmp_path / "a.cgns", items(number, types))
        assert read_mesh(tmp_path / "a.cgns").counts == {"hexahedron": 1, "pyramid": 1}


# ---- ADF -------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("binary", [True, False])
def test_both_database_versions_of_adf_hold_the_same_mesh(tmp_path, binary, order):
    as_adf(tmp_path / "a.cgns", hexa_zone(FAMILIES), binary, order)
    as_hdf5(tmp_path / "b.cgns", hexa_zone(FAMILIES))
    one, other = read_mesh(tmp_path / "a.cgns"), read_mesh(tmp_path / "b.cgns")
    assert np.array_equal(one.points, other.points)
    assert one.counts == other.counts
    assert one.markers.keys() == other.markers.keys()
    write_mesh(one, tmp_path / "c.cgns", one.points + 1 / 3)
    assert np.array_equal(read_mesh(tmp_path / "c.cgns").points, one.points + 1 / 3)


def test_damaged_pointers_of_adf_are_refused(tmp_path):
    as_adf(tmp_path / "a.cgns", hexa_zone())
    data = (tmp_path / "a.cgns").read_bytes()
    random = np.random.default_rng(2)
    table = [k for k in range(len(data)) if data.startswith(b"SNTb", k)]
    for _ in range(60):
        place = int(random.choice(table)) + 16 + 32 + int(random.integers(12))
        wrong = data[:place] + bytes([int(random.integers(1, 256))]) + data[place + 1 :]
        (tmp_path / "a.cgns").write_bytes(wrong)
        with warnings.catch_warnings(), contextlib.suppress(InputError):
            warnings.simplefilter("ignore", MeshWarning)
            read_mesh(tmp_path / "a.cgns")  # whatever else it raises fails


# ---- connections -----------------------------------------------------------------------------


def two_blocks(turn: tuple[int, ...] = (1, 2, 3)) -> list[dict]:
    """Blocks that meet at i = 4 of the first; the second one's directions are turned."""
    one = positions([range(n) for n in SHAPE])
    other = positions([range(n) for n in SHAPE], shift=3.0)
    ends = [[4, 1, 1], [4, 3, 2]]
    back = [[1, 1, 1], [1, 3, 2]]
    if turn == (-2, 1, 3):  # direction 1 runs against j of the other, 2 along its i
        other = other.transpose(0, 2, 1, 3)[:, ::-1]
        back = [[1, 4, 1], [3, 4, 2]]
    links = {"match": ("B", ends, back, turn if turn != (1, 2, 3) else None)}
    return [{"name": "A", "points": one, "links": links}, {"name": "B", "points": other}]


@pytest.mark.parametrize("turn", [(1, 2, 3), (-2, 1, 3)])
def test_vertices_that_a_connection_pairs_are_partners(tmp_path, turn):
    as_hdf5(tmp_path / "a.cgns", structured(two_blocks(turn)))
    mesh = read_mesh(tmp_path / "a.cgns")
    [pair] = pairs_of(mesh)
    assert pair.names == ("A/match", "B")
    assert len(pair.first) == 6
    assert np.abs(mesh.points[pair.first] - mesh.points[pair.second]).max() < 1e-12
    torn = mesh.points + np.arange(len(mesh.points))[:, None] // 24 * [0, 0.1, 0]
    assert broken(mesh, mesh.points * [1, 2, 3]) == []
    assert broken(mesh, torn) == [
        "A/match and B no longer match: 6 of 6 nodes have their partners elsewhere, by up to 0.1"
    ]


def test_a_zone_that_is_periodic_with_itself_keeps_its_pitch(tmp_path):
    own = {"name": "A", "points": positions([range(n) for n in SHAPE])}
    low, high = [[1, 1, 1], [4, 1, 2]], [[1, 3, 1], [4, 3, 2]]
    own["links"] = {"down": ("A", low, high, (1, 2, 3)), "up": ("A", high, low, (1, 2, 3))}
    as_hdf5(tmp_path / "a.cgns", structured([own]))
    mesh = read_mesh(tmp_path / "a.cgns")
    [pair] = pairs_of(mesh)
    assert pair.shift == pytest.approx([0.2, 2.0, 0.0])
    assert len(pair.first) == 8
    assert len(broken(mesh, mesh.points * [1, 1.5, 1])) == 1


def lists(label: str, kind: str, location: str) -> Item:
    return Item(
        "list",
        label,
        text("Zone 1"),
        (
            Item("GridConnectivityType", "GridConnectivityType_t", text(kind)),
            Item("GridLocation", "GridLocation_t", text(location)),
            Item("PointList", "IndexArray_t", np.array([[1], [2], [3]], np.int32)),
            Item("PointListDonor", "IndexArray_t", np.array([[34], [35], [36]], np.int32)),
        ),
    )


def with_connection(item: Item) -> list[Item]:
    *head, base = hexa_zone()
    zone = base.children[-1]
    group = Item("ZoneGridConnectivity", "ZoneGridConnectivity_t", None, (item,))
    zone = zone._replace(children=(*zone.children, group))
    return [*head, base._replace(children=(*base.children[:-1], zone))]


def test_lists_of_vertices_are_partners_and_lists_of_faces_are_told(tmp_path):
    path = tmp_path / "a.cgns"
    as_hdf5(path, with_connection(lists("GridConnectivity_t", "Abutting1to1", "Vertex")))
    [pair] = pairs_of(read_mesh(path))
    assert (pair.first.tolist(), pair.second.tolist()) == ([0, 1, 2], [33, 34, 35])
    as_hdf5(path, with_connection(lists("GridConnectivity_t", "Overset", "Vertex")))
    assert pairs_of(read_mesh(path)) == ()
    as_hdf5(path, with_connection(lists("GridConnectivity_t", "Abutting1to1", "FaceCenter")))
    with pytest.warns(MeshWarning, match="between faces are kept but not watched: list"):
        read_mesh(path)


LOW = [[1, 1, 1], [4, 1, 1]]


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        ({"links": {"a": ("A", [[1, 1, 1], [9, 1, 1]], LOW, None)}}, "outside"),
        ({"links": {"a": ("A", LOW, [[1, 3, 9], [4, 3, 9]], None)}}, "outside"),
        (
            {"links": {"a": ("A", LOW, [[1, 3, 1], [4, 3, 1]], (1, 1, 3))}},
            "none",
        ),
        ({"rind": (2, 2, 0, 0, 0, 0)}, "all rind"),
        ({"rind": (-1, 0, 0, 0, 0, 0)}, "do not fit"),
    ],
)
def test_connections_and_rind_that_do_not_fit_are_refused(tmp_path, change, cause):
    own = {"name": "A", "points": positions([range(n) for n in SHAPE]), **change}
    as_hdf5(tmp_path / "a.cgns", structured([own]))
    with pytest.raises(InputError, match=cause):
        read_mesh(tmp_path / "a.cgns")


# ---- rind planes -----------------------------------------------------------------------------


def with_rind(**storage):
    """Two blocks that meet at x = 3; each has one plane of the other as rind, and A one outside."""

    def write(path) -> None:
        wall = {"low": ("wing surface", [1, 1, 1], [4, 1, 2])}
        one = positions([range(-1, 5), range(3), range(2)])
        other = positions([range(-1, 4), range(3), range(2)], shift=3.0)
        blocks = [
            {"name": "A", "points": one, "rind": (1, 1, 0, 0, 0, 0), "conditions": wall},
            {"name": "B", "points": other, "rind": (1, 0, 0, 0, 0, 0), "conditions": wall},
        ]
        as_hdf5(path, structured(blocks), **storage)

    return write


@pytest.mark.filterwarnings("ignore::ffdstudio.meshes.MeshWarning")
@pytest.mark.parametrize("storage", [{}, {"chunks": True, "compression": "gzip"}])
def test_rind_planes_are_no_mesh_but_move_with_what_they_copy(tmp_path, storage):
    path = tmp_path / "a.cgns"
    with_rind(**storage)(path)
    mesh = read_mesh(path)
    assert len(mesh.points) == 2 * 4 * 3 * 2
    assert mesh.counts == {"hexahedron": 2 * 3 * 2}
    wall = mesh.points[mesh.marker_nodes("wing surface")]
    assert (wall[:, 0].min(), wall[:, 0].max()) == (0, 6)
    write_mesh(mesh, tmp_path / "same.cgns", mesh.points.copy())
    assert (tmp_path / "same.cgns").read_bytes() == path.read_bytes()
    write_mesh(mesh, tmp_path / "moved.cgns", mesh.points * [1, 2, 3])
    with h5py.File(path) as old, h5py.File(tmp_path / "moved.cgns") as new:
        for name in "AB":
            was, now = (f[f"Base/{name}/GridCoordinates/CoordinateY/ data"][()] for f in (old, new))
            outside = slice(1, None) if name == "A" else slice(None)
            assert np.array_equal(now[..., outside], 2 * was[..., outside])
            if name == "A":  # nobody knows where the plane outside of all blocks goes
                assert np.array_equal(now[..., 0], was[..., 0])


def test_rind_nodes_that_are_no_copies_are_told(tmp_path):
    with_rind()(tmp_path / "a.cgns")
    with pytest.warns(MeshWarning, match="6 nodes in rind planes are no copies"):
        read_mesh(tmp_path / "a.cgns")
