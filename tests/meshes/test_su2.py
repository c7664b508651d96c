"""SU2: every trap of the format, and the promise that only moved nodes' lines change."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes import MeshWarning
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.formats import su2
from ffdstudio.meshes.pairs import pairs_of

REAL = [
    "su2/mesh_NACA0012_inv.su2",
    "su2/mesh_RAE2822_turb_ffd.su2",
    "su2/mesh_NACA64A010_hybrid_inv.su2",
    "su2/mesh_brick_prism_ffd.su2",
    "wing/oneram6_tets.su2",
]
TRAPS = b"""\
% a comment with NPOIN= 7 in it\r
MARKERTAG=wall \r
MARKER_ELEMS= 2 % two\r
3 0\t1\r
3 1 2 0\r
NPOIN= 4 4   % two numbers\r
\t 0.0 -0.0 0 %  first\r
1D0 0. 1\r
% between\r
\r
1.00 1e0 2\r
  0 +1 3 3\r
NDIME=2\r
NELEM=2\r
9 0 1 2 3\r
 5 0 1 2 1 % with index\r
NMARK=2\r
MARKER_TAG= SEND_RECEIVE\r
MARKER_ELEMS= 2\r
SEND_RECV= 1\r
1 0 0\r
1 3 0\r
NPERIODIC= 1\r
PERIODIC_INDEX= 0\r
0 0 0\r
"""
ZONES = b"""NZONE= 2
IZONE= 1
NDIME= 2
NPOIN= 3
0 0
1 0
0 1
NELEM= 1
5 0 1 2
NMARK= 1
MARKER_TAG= wall
MARKER_ELEMS= 1
3 0 1
IZONE= 2
NDIME= 2
NELEM= 1
5 0 1 2
NPOIN= 3
2 0
3 0
2 1
NMARK= 1
MARKER_TAG= wall
MARKER_ELEMS= 1
3 1 2
"""


def written(tmp_path: Path, data: bytes, move=None) -> tuple[bytes, np.ndarray]:
    source, target = tmp_path / "in.su2", tmp_path / "out.su2"
    source.write_bytes(data)
    mesh = read_mesh(source)
    points = mesh.points.copy()
    if move:
        move(points)
    write_mesh(mesh, target, points)
    return target.read_bytes(), points


def node_lines(data: bytes, axes: int) -> tuple[list[int], np.ndarray]:
    """Line numbers and coordinates of a one-zone file, by plain Python."""
    lines = data.decode().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("NPOIN=")) + 1
    count = int(lines[first - 1].split("=")[1].split()[0])
    rows = range(first, first + count)
    return list(rows), np.array([[float(t) for t in lines[k].split()[:axes]] for k in rows])


@pytest.mark.parametrize("name", REAL)
def test_real_mesh_at_rest_keeps_its_bytes(shared, tmp_path, name):
    data = (shared / "meshes" / name).read_bytes()
    mesh = read_mesh(shared / "meshes" / name)
    assert mesh.template.patched(mesh.points) == data


@pytest.mark.parametrize("name", REAL)
def test_only_moved_nodes_lines_change_and_hold_the_exact_doubles(shared, tmp_path, name):
    data = (shared / "meshes" / name).read_bytes()
    mesh = read_mesh(shared / "meshes" / name)
    rng = np.random.default_rng(1)
    moved = rng.random(len(mesh.points)) < 0.3
    points = mesh.points.copy()
    points[moved, : mesh.dimension] += rng.normal(0, 0.1, (moved.sum(), mesh.dimension))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        write_mesh(mesh, tmp_path / "out.su2", points)
    new = (tmp_path / "out.su2").read_bytes()
    rows, values = node_lines(new, mesh.dimension)
    assert np.array_equal(values, points[:, : mesh.dimension])
    pairs = zip(data.splitlines(), new.splitlines(), strict=True)
    different = [k for k, (old, line) in enumerate(pairs) if old != line]
    assert different == [rows[k] for k in np.flatnonzero(moved)]


@pytest.mark.parametrize("name", ["su2/mesh_NACA0012_inv.su2", "wing/oneram6_tets.su2"])
def test_meshio_reads_the_same_mesh(shared, name):
    meshio = pytest.importorskip("meshio")
    theirs, ours = meshio.read(shared / "meshes" / name), read_mesh(shared / "meshes" / name)
    assert np.array_equal(theirs.points, ours.points[:, : ours.dimension])
    for kind, nodes in ours.cells.items():
        assert np.array_equal(theirs.cells_dict[kind], nodes)


def test_every_trap_of_the_format_is_understood(tmp_path):
    (tmp_path / "a.su2").write_bytes(TRAPS)
    mesh = read_mesh(tmp_path / "a.su2")
    assert mesh.dimension == 2
    assert mesh.points[:, :2].tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert mesh.counts == {"triangle": 1, "quad": 1}
    assert mesh.marker_counts == {"wall": 2, "SEND_RECEIVE": 2}
    assert mesh.markers["SEND_RECEIVE"]["vertex"].tolist() == [[0], [3]]


def test_moving_one_node_changes_its_tokens_and_nothing_else(tmp_path):
    def move(points):
        points[2, 0] = 0.1

    assert written(tmp_path, TRAPS)[0] == TRAPS
    assert written(tmp_path, TRAPS, move)[0] == TRAPS.replace(b"1.00 1e0 2", b"0.1 1e0 2")


def test_zones_are_joined_and_named(tmp_path):
    (tmp_path / "a.su2").write_bytes(ZONES)
    mesh = read_mesh(tmp_path / "a.su2")
    assert mesh.cells["triangle"].tolist() == [[0, 1, 2], [3, 4, 5]]
    assert mesh.markers["zone 2/wall"]["line"].tolist() == [[4, 5]]
    assert mesh.markers["zone 2"]["triangle"].tolist() == [[3, 4, 5]]
    assert mesh.boundaries == ["zone 1/wall", "zone 2/wall"]

    def move(points):
        points[4, 1] = -1 / 3

    new = written(tmp_path, ZONES, move)[0]
    assert new == ZONES.replace(b"3 0\n2 1", b"3 -0.3333333333333333\n2 1")


def test_a_plane_mesh_refuses_to_leave_its_plane(tmp_path):
    def move(points):
        points[1, 2] = 1e-9

    with pytest.raises(InputError, match=r"holds xy only, but node 1 .* moves along z"):
        written(tmp_path, TRAPS, move)


def test_embedded_boxes_are_kept_with_a_warning_replaced_or_stripped(tmp_path):
    section = b"FFD_NBOX= 1\nFFD_TAG= A\n 1 2 3\n"
    data = ZONES[ZONES.index(b"NDIME") : ZONES.index(b"IZONE= 2")]
    tail = b"NPERIODIC= 0\n"
    (tmp_path / "a.su2").write_bytes(section + data + tail)
    mesh = read_mesh(tmp_path / "a.su2")
    assert su2.ffd_sections(mesh) == [section]
    moved = mesh.points + np.array([0.5, 0, 0])
    with pytest.warns(MeshWarning, match="FFD boxes inside the file are kept"):
        write_mesh(mesh, tmp_path / "b.su2", moved)
    expected = data.replace(b"0 0\n1 0\n0 1", b"0.5 0\n1.5 0\n0.5 1") + tail
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write_mesh(su2.replace_ffd_sections(mesh, []), tmp_path / "b.su2", moved)
        assert (tmp_path / "b.su2").read_bytes() == expected
        other = su2.replace_ffd_sections(mesh, [b"FFD_NBOX= 2\n"])
        write_mesh(other, tmp_path / "b.su2", moved)
        assert (tmp_path / "b.su2").read_bytes() == b"FFD_NBOX= 2\n" + expected
    assert su2.ffd_sections(su2.replace_ffd_sections(other, [])) == []


def test_stripping_boxes_leaves_every_line_that_is_not_theirs(tmp_path):
    box = b"FFD_NBOX= 1\nFFD_TAG= A\n 1 2 3\n"
    comment = b"% behind the boxes\n\n"
    first, second = ZONES.split(b"IZONE= 2")
    clean = [first + comment, b"IZONE= 2" + second + comment]
    (tmp_path / "a.su2").write_bytes(first + box + clean[0][len(first) :] + clean[1] + box)
    mesh = read_mesh(tmp_path / "a.su2")
    assert su2.ffd_sections(mesh) == [box, box]
    write_mesh(su2.replace_ffd_sections(mesh, []), tmp_path / "b.su2")
    assert (tmp_path / "b.su2").read_bytes() == b"".join(clean)
    points = mesh.points.copy()
    points[4, 1] = -1 / 3
    write_mesh(su2.replace_ffd_sections(mesh, [b"", b"FFD_NBOX= 0\n"]), tmp_path / "b.su2", points)
    moved = b"".join(clean).replace(b"3 0\n2 1", b"3 -0.3333333333333333\n2 1")
    assert (tmp_path / "b.su2").read_bytes() == moved + b"FFD_NBOX= 0\n"


def test_a_keyword_of_boxes_behind_the_nodes_does_not_take_the_nodes_with_it(tmp_path):
    head, tail = ZONES[ZONES.index(b"NDIME") : ZONES.index(b"IZONE= 2")].split(b"NPOIN")
    tail = b"NPOIN" + tail
    (tmp_path / "a.su2").write_bytes(head + b"FFD_NBOX= 1\n" + tail + b"FFD_LEVEL= 0\n")
    mesh = read_mesh(tmp_path / "a.su2")
    write_mesh(su2.replace_ffd_sections(mesh, []), tmp_path / "b.su2")
    assert (tmp_path / "b.su2").read_bytes() == head + tail


BROKEN = {
    "empty": (b"", "there is no NDIME= section"),
    "noise": (bytes(range(256)) * 40, "line|there is no"),
    "cut in the nodes": (
        b"NDIME=2\nNELEM=0\n" + TRAPS[: TRAPS.index(b"1.00")],
        "line 8: NPOIN= announces 4 nodes, but 2",
    ),
    "nan": (TRAPS.replace(b"1.00", b"nan"), "line 11: a coordinate is not a finite number"),
    "overflow": (TRAPS.replace(b"1.00", b"1e999"), "line 11: a coordinate is not a finite"),
    "word": (TRAPS.replace(b"1.00", b"abc"), "line 11: expected a number, found 'abc'"),
    "index": (TRAPS.replace(b"9 0 1 2 3", b"9 0 1 2 4"), "line 15: a node index is not in 0 to 3"),
    "negative": (TRAPS.replace(b"3 0\t1", b"3 0\t-1"), "line 4: a node index is not in 0 to 3"),
    "type": (TRAPS.replace(b"9 0 1 2 3", b"7 0 1 2 3"), "line 15: unknown element type 7"),
    "short": (TRAPS.replace(b"9 0 1 2 3", b"9 0 1 2"), "line 15: a quad has 4 nodes, found 3"),
    "count": (TRAPS.replace(b"NELEM=2", b"NELEM=3"), "line 14: NELEM= announces 3 elements"),
    "minus": (TRAPS.replace(b"NELEM=2", b"NELEM=-2"), "line 14: NELEM= must be at least 0"),
    "huge": (TRAPS.replace(b"NPOIN= 4 4", b"NPOIN= 99999999999999"), "NPOIN= announces"),
    "float": (TRAPS.replace(b"9 0 1 2 3", b"9 0 1 2.5 3"), "expected a whole number, found '2.5'"),
    "dimension": (TRAPS.replace(b"NDIME=2", b"NDIME=4"), "NDIME= must be 2 or 3, not 4"),
    "markers": (TRAPS.replace(b"NMARK=2", b"NMARK=3"), "NMARK= announces 3 markers, found 2"),
    "zones": (ZONES.replace(b"NZONE= 2", b"NZONE= 3"), "announces 3 zones, the file has 2"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_damaged_file_is_refused_with_place_and_cause(tmp_path, name):
    data, cause = BROKEN[name]
    (tmp_path / "bad.su2").write_bytes(data)
    with pytest.raises(InputError, match=cause) as caught:
        read_mesh(tmp_path / "bad.su2")
    assert "bad.su2" in str(caught.value)


def test_reading_can_be_cancelled_and_reports_progress(tmp_path):
    (tmp_path / "a.su2").write_bytes(TRAPS)
    seen = []
    read_mesh(tmp_path / "a.su2", progress=seen.append)
    assert seen[0] == 0
    assert seen[-1] == 1

    def cancel(fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        read_mesh(tmp_path / "a.su2", progress=cancel)


def test_an_unwritable_target_leaves_the_old_file(tmp_path):
    (tmp_path / "a.su2").write_bytes(TRAPS)
    mesh = read_mesh(tmp_path / "a.su2")
    with pytest.raises(InputError, match="cannot write"):
        write_mesh(mesh, tmp_path / "no such folder" / "b.su2")
    with pytest.raises(InputError, match="not a finite number"):
        write_mesh(mesh, tmp_path / "a.su2", np.full_like(mesh.points, np.nan))
    assert (tmp_path / "a.su2").read_bytes() == TRAPS


HALO = """NDIME= 2
NELEM= 2
9 0 1 4 3
9 1 2 5 4
NPOIN= 6
0 0
1 0
2 0
0 1
1 1
2 1
NMARK= {count}
MARKER_TAG= floor
MARKER_ELEMS= 1
SEND_TO= 0 % a wall
3 0 1
{halos}"""
SENT = "MARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= {}\n{}= {}\n{}\n"


def halos(*rows: tuple[str, int, list[int]]) -> str:
    parts = [
        SENT.format(len(nodes), key, number, "\n".join(f"1 {n} 0" for n in nodes))
        for key, number, nodes in rows
    ]
    return HALO.format(count=1 + len(rows), halos="".join(parts))


@pytest.mark.parametrize("key", ["SEND_TO", "SEND_RECV"])
@pytest.mark.parametrize("sign", [1, -1])
def test_nodes_sent_and_received_are_partners_under_either_keyword(tmp_path, key, sign):
    (tmp_path / "a.su2").write_text(halos((key, sign, [0, 3]), (key, -sign, [2, 5])))
    mesh = read_mesh(tmp_path / "a.su2")
    assert mesh.marker_counts == {"floor": 1, "SEND_RECEIVE": 4}
    [pair] = pairs_of(mesh)
    first, second = (pair.first, pair.second)[::sign]
    assert (first.tolist(), second.tolist()) == ([0, 3], [2, 5])
    bent = mesh.points + [0, 0.1, 0] * (mesh.points[:, :1] == 2)
    [sentence] = broken(mesh, bent)
    assert sentence.startswith("SEND_RECEIVE no longer match: 2 of 2 nodes")


def test_two_directions_of_halos_are_kept_apart(tmp_path):
    rows = [("SEND_RECV", 1, [0, 3]), ("SEND_RECV", -1, [2, 5])]
    rows += [("SEND_RECV", 2, [0, 1, 2]), ("SEND_RECV", -2, [3, 4, 5])]
    (tmp_path / "a.su2").write_text(halos(*rows))
    mesh = read_mesh(tmp_path / "a.su2")
    assert [pair.shift.tolist() for pair in pairs_of(mesh)] == [[2, 0, 0], [0, 1, 0]]
    assert broken(mesh, mesh.points + [0.5, 0.25, 0]) == []


@pytest.mark.parametrize("key", ["NDIME= 2\nNZONE= 2\n", "NZONE= 2\nNDIME= 2\n% all\n"])
@pytest.mark.parametrize("again", [True, False])
def test_what_stands_before_the_first_zone_is_said_of_all(tmp_path, key, again):
    text = ZONES.decode().replace("NZONE= 2\n", "")
    (tmp_path / "a.su2").write_text(key + (text if again else text.replace("NDIME= 2\n", "")))
    mesh = read_mesh(tmp_path / "a.su2")
    assert mesh.dimension == 2
    assert mesh.marker_counts == {"zone 1": 1, "zone 1/wall": 1, "zone 2": 1, "zone 2/wall": 1}
