"""FFD boxes inside SU2 meshes."""

import math
import shutil

import numpy as np
import pytest

from ffdstudio import InputError, Lattice, embed, read_lattice, read_mesh, write_lattice
from ffdstudio.exchange import read_lattice_file, su2, su2text
from ffdstudio.exchange.morphed import write_morphed
from ffdstudio.meshes import MeshWarning

SQUARE = """NDIME= 2
NELEM= 2
5 0 1 2
5 0 2 3
NPOIN= 4
0.0 0.0
1.0 0.0
1.0 1.0
0.0 1.0
NMARK= 1
MARKER_TAG= wall
MARKER_ELEMS= 2
3 0 1
3 1 2
"""
BOX = """FFD_NBOX= 1
FFD_NLEVEL= 1
FFD_TAG= A
FFD_LEVEL= 0
FFD_DEGREE_I= 1
FFD_DEGREE_J= 1
FFD_BLENDING= BEZIER
FFD_PARENTS= 0
FFD_CHILDREN= 0
FFD_CORNER_POINTS= 4
-1.0\t-1.0
2.0\t-1.0
2.0\t2.0
-1.0\t2.0
FFD_CONTROL_POINTS= 0
FFD_SURFACE_POINTS= 0
"""


def surface(data):
    """Cached embedding of the first box: (marker, node) -> u, v, w."""
    lines = data.decode().split("FFD_SURFACE_POINTS= ")[1].splitlines()
    rows = [line.split("\t") for line in lines[1 : 1 + int(lines[0])]]
    return {(row[0], int(row[1])): [float(x) for x in row[2:]] for row in rows}


def bernstein(n, i, t):
    return math.comb(n, i) * t**i * (1 - t) ** (n - i)


@pytest.mark.parametrize(
    ("name", "shape"),
    [("mesh_RAE2822_turb_ffd", (15, 2)), ("mesh_brick_prism_ffd", (5, 5, 2))],
)
def test_a_real_box_maps_the_cached_embedding_onto_the_mesh(shared, name, shape):
    path = shared / "meshes" / "su2" / f"{name}.su2"
    rest, current = read_lattice(path)
    assert rest.shape == shape
    assert rest == current
    mesh, cached = read_mesh(path), surface(path.read_bytes())
    nodes = [node for _, node in cached]
    u = np.array(list(cached.values()))[:, : len(shape)]
    distance = np.abs(rest.evaluate(u) - mesh.points[nodes])[:, : len(shape)]
    assert distance.max() < 1e-12


def test_a_bezier_box_is_the_bernstein_sum(shared):
    path = shared / "meshes" / "su2" / "mesh_brick_prism_ffd.su2"
    rest, _ = read_lattice(path)
    u = np.random.default_rng(2).random((20, 3))
    expected = np.zeros((20, 3))
    for index in np.ndindex(5, 5, 2):
        factors = [
            bernstein(n - 1, i, u[:, k])
            for k, (i, n) in enumerate(zip(index, (5, 5, 2), strict=True))
        ]
        expected += np.prod(factors, axis=0)[:, None] * rest.control_points[index]
    assert np.abs(rest.evaluate(u) - expected).max() < 1e-14


@pytest.mark.parametrize("name", ["mesh_RAE2822_turb_ffd", "mesh_brick_prism_ffd"])
def test_our_embedding_is_the_one_su2_wrote(shared, tmp_path, name):
    source = shared / "meshes" / "su2" / f"{name}.su2"
    path = tmp_path / "m.su2"
    shutil.copyfile(source, path)
    assert write_lattice(path, read_lattice(source)[0], tag="MAIN_BOX").exact
    theirs, ours = surface(source.read_bytes()), surface(path.read_bytes())
    assert ours.keys() == theirs.keys()
    assert max(np.abs(np.subtract(ours[key], theirs[key])).max() for key in ours) < 1e-12


def test_writing_a_box_touches_nothing_before_it(shared, tmp_path):
    source = shared / "meshes" / "su2" / "mesh_brick_prism_ffd.su2"
    path = tmp_path / "m.su2"
    shutil.copyfile(source, path)
    write_lattice(path, read_lattice(source)[0], tag="MAIN_BOX")
    before, after = (p.read_bytes().split(b"FFD_NBOX=")[0] for p in (source, path))
    assert before == after


def test_parsing_and_putting_back_gives_the_same_bytes(shared):
    for name in ("mesh_RAE2822_turb_ffd", "mesh_brick_prism_ffd"):
        data = (shared / "meshes" / "su2" / f"{name}.su2").read_bytes()
        section = su2text.parse(data, name)
        assert su2text.replaced(data, section) == data


def strict_lines(data):
    """The section as SU2's own line-by-line reader would take it."""
    lines = data.decode().split("FFD_NBOX= ")[1].split("\n")
    keys = [line.split("=")[0] for line in lines if "=" in line]
    for line in lines:
        assert line == line.rstrip()
        assert "\r" not in line
        if "=" in line:
            assert line.split("=")[1].startswith(" ")
            assert not line.split("=")[1].startswith("  ")
    return keys


@pytest.mark.parametrize(("degrees", "orders"), [((3, 2), ["I", "J"]), ((5, 3), [])])
def test_a_new_box_has_the_fixed_order_of_keys(tmp_path, degrees, orders):
    path = tmp_path / "m.su2"
    path.write_text(SQUARE)
    box = Lattice.box([-0.5, -0.5], [1.5, 1.5], shape=(6, 4), degrees=degrees)
    assert write_lattice(path, box, tag="B").exact
    assert strict_lines(path.read_bytes()) == [
        "FFD_NLEVEL",
        "FFD_TAG",
        "FFD_LEVEL",
        "FFD_DEGREE_I",
        "FFD_DEGREE_J",
        "FFD_BLENDING",
        *[f"BSPLINE_ORDER_{d}" for d in orders],
        "FFD_PARENTS",
        "FFD_CHILDREN",
        "FFD_CORNER_POINTS",
        "FFD_CONTROL_POINTS",
        "FFD_SURFACE_POINTS",
    ]
    found = read_lattice_file(path, "B").rest
    assert np.array_equal(found.control_points, box.control_points)
    assert found.degrees == degrees
    assert {key[1] for key in surface(path.read_bytes())} == {0, 1, 2}


def test_a_deformed_box_keeps_its_net_and_the_mesh_its_place(tmp_path):
    path = tmp_path / "m.su2"
    path.write_text(SQUARE)
    box = Lattice.box([-0.5, -0.5], [1.5, 1.5], shape=(5, 4))
    bent = box.moved(box.control_points + 0.1 * np.sin(3 * box.control_points[..., :1]) * [0, 1, 0])
    write_lattice(path, bent, tag="B")
    mesh, lattice = read_mesh(path), read_lattice(path)[0]
    for (_, node), u in surface(path.read_bytes()).items():
        assert np.abs(lattice.evaluate([u[:2]])[0] - mesh.points[node]).max() < 1e-12


def test_several_boxes_are_chosen_by_tag_and_keep_their_bytes(tmp_path):
    path = tmp_path / "m.su2"
    nested = BOX.replace("NBOX= 1", "NBOX= 2").replace("NLEVEL= 1", "NLEVEL= 2")
    child = BOX.split("NLEVEL= 1\n")[1].replace("TAG= A", "TAG= B").replace("LEVEL= 0", "LEVEL= 1")
    child = child.replace("PARENTS= 0", "PARENTS= 1\nA").replace("-1.0\t", "-0.5\t")
    path.write_text(SQUARE + nested.replace("CHILDREN= 0", "CHILDREN= 1\nB") + child)
    assert su2.tags(path.read_bytes(), "m") == ["A", "B"]
    found = read_lattice_file(path, "B")
    assert found.rest.control_points[0, 0, 0] == -0.5
    assert "parents: A" in str(found.exactness) or "corners" in str(found.exactness)
    before = path.read_text()
    write_lattice(path, Lattice.box([0, 0], [1, 1], shape=(3, 3)), tag="C")
    assert su2.tags(path.read_bytes(), "m") == ["A", "B", "C"]
    assert before.split("FFD_NLEVEL= 2\n")[1] in path.read_text()
    with pytest.raises(InputError, match="no FFD box D; it has: A, B, C"):
        read_lattice(path, block="D")


def test_a_box_that_is_not_set_up_is_spanned_by_its_corners(tmp_path):
    path = tmp_path / "m.su2"
    path.write_text(SQUARE + BOX.replace("DEGREE_I= 1", "DEGREE_I= 3"))
    rest, _ = read_lattice(path)
    assert np.abs(rest.control_points[:, 0, 0] - [-1, 0, 1, 2]).max() < 1e-15
    assert np.array_equal(rest.control_points[0, :, 1], [-1, 2])


def test_a_mesh_that_moved_takes_its_box_along(tmp_path):
    mesh = write_square(tmp_path / "m.su2")
    rest = Lattice.box([-0.5, -0.5], [1.5, 1.5], shape=(4, 4))
    points = rest.control_points.copy()
    points[1:3, 1:3, 1] += 0.2
    current = rest.moved(points)
    write_lattice(tmp_path / "m.su2", rest, tag="SAME")
    write_lattice(tmp_path / "m.su2", Lattice.box([-1, -1], [2, 2], shape=(3, 3)), tag="OTHER")
    new = embed(rest, mesh.points).deform(current)
    data = (tmp_path / "m.su2").read_bytes()
    after = su2.follow(data, mesh, new, [(rest, current)])
    same = su2.read(after, "m", "SAME").rest
    assert np.array_equal(same.control_points, points)
    assert surface(after)[("wall", 1)] == surface(data)[("wall", 1)]  # the box that moved it
    other = after.split(b"FFD_TAG= OTHER")[1]
    lattice = su2.read(after, "m", "OTHER").rest
    for (_, node), u in surface(other).items():
        assert np.abs(lattice.evaluate([u[:2]])[0] - new[node]).max() < 1e-12


def test_a_morphed_mesh_is_written_with_its_boxes_updated_stripped_or_kept(tmp_path):
    write_square(tmp_path / "m.su2")
    rest = Lattice.box([-0.5, -0.5], [1.5, 1.5], shape=(4, 4))
    write_lattice(tmp_path / "m.su2", rest, tag="BOX")
    mesh = read_mesh(tmp_path / "m.su2")
    current = rest.moved(rest.control_points + [0.0, 0.25, 0.0])
    new = embed(rest, mesh.points).deform(current)

    def written(boxes):
        write_morphed(mesh, tmp_path / "out.su2", new, [(rest, current)], boxes)
        assert np.array_equal(read_mesh(tmp_path / "out.su2").points, new)
        return (tmp_path / "out.su2").read_bytes()

    updated = su2.read(written("update"), "m", "BOX").rest
    assert np.array_equal(updated.control_points, current.control_points)
    assert su2.tags(written("strip"), "m") == []
    with pytest.warns(MeshWarning, match="kept as they were"):
        kept = su2.read(written("keep"), "m", "BOX").rest
    assert np.array_equal(kept.control_points, rest.control_points)
    write_morphed(mesh, tmp_path / "out.su2", mesh.points, [(rest, rest)])
    assert (tmp_path / "out.su2").read_bytes() == (tmp_path / "m.su2").read_bytes()


def write_square(path):
    path.write_text(SQUARE)
    return read_mesh(path)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("NDIME= 2", "NDIME= 7", "NDIME"),
        ("FFD_NBOX= 1", "FFD_NBOX= 2", "ends too early"),
        ("FFD_NBOX= 1", "FFD_NBOX= x", "whole number"),
        ("FFD_LEVEL= 0\n", "", "FFD_LEVEL= expected"),
        ("FFD_DEGREE_I= 1", "FFD_DEGREE_I= 0", "degree"),
        ("FFD_DEGREE_I= 1", "FFD_DEGREE_I= 99999999999", "out of range"),
        ("BEZIER", "NURBS", "'NURBS' is not known"),
        ("CORNER_POINTS= 4", "CORNER_POINTS= 8", "must be 4"),
        ("-1.0\t-1.0", "nan\t-1.0", "finite"),
        ("CONTROL_POINTS= 0", "CONTROL_POINTS= 3", "does not fit the degrees"),
        ("SURFACE_POINTS= 0", "SURFACE_POINTS= 4", "ends too early"),
        ("CONTROL_POINTS= 0", "CONTROL_POINTS= 8" + "\n0 0 0 0.0 0.0 0.0" * 8, "missing"),
        ("CONTROL_POINTS= 0", "CONTROL_POINTS= 8" + "\n9 0 0 0.0 0.0 0.0" * 8, "wrong FFD control"),
    ],
)
def test_a_broken_section_is_refused_in_one_sentence(tmp_path, old, new, words):
    path = tmp_path / "m.su2"
    assert old in SQUARE + BOX
    path.write_text((SQUARE + BOX).replace(old, new, 1))
    with pytest.raises(InputError, match=words):
        read_lattice(path)


def test_carriage_returns_blanks_and_comments_are_read(tmp_path):
    path = tmp_path / "m.su2"
    text = (SQUARE + BOX).replace("BEZIER", "BEZIER  % polynomial").replace("\n", " \r\n\r\n")
    path.write_bytes(text.encode())
    assert read_lattice(path)[0].shape == (2, 2)


def test_what_su2_cannot_say_is_refused(tmp_path):
    path = tmp_path / "m.su2"
    path.write_text(SQUARE)
    box = Lattice.box([0, 0], [1, 1], shape=(4, 4))
    with pytest.raises(InputError, match="weights"):
        write_lattice(path, box.moved(weights=np.full((4, 4), 0.5)))
    with pytest.raises(InputError, match="2 directions, not 3"):
        write_lattice(path, Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 4, 4)))
    with pytest.raises(InputError, match="one word"):
        write_lattice(path, box, tag="MAIN BOX")
    with pytest.raises(InputError, match="one word"):
        write_lattice(path, box, tag=5)
    for markers in ("hull", 5):
        with pytest.raises(InputError, match="a list of names"):
            write_lattice(path, box, markers=markers)
    with pytest.raises(InputError, match="no marker hull"):
        write_lattice(path, box, markers=["hull"])
    assert path.read_text() == SQUARE


@pytest.mark.parametrize("shape", [(5, 3), (4, 3, 3)])
def test_the_configuration_spells_the_same_box(tmp_path, shape):
    path = tmp_path / "box.cfg"
    ends = [-1.0, -2.0, -3.0], [1.0, 1.0, 1.0]
    box = Lattice.box(*ends, shape=shape, degrees=[n - 1 for n in shape], spacing="uniform")
    assert write_lattice(path, box, frozen=1, tag="WING").exact
    text = path.read_text()
    assert text.startswith("FFD_DEFINITION= (WING, ")
    assert f"FFD_FIX_I= (0, {shape[0] - 1})" in text
    back = read_lattice(path)[0]
    assert back.shape == shape
    assert np.abs(back.control_points - box.control_points).max() < 1e-15
    bent = box.moved(box.control_points**2)
    with pytest.raises(InputError, match="evenly"):
        write_lattice(path, bent)
