"""A number too many in the line of a node would shift its coordinates: it is told, not guessed."""

import meshio
import numpy as np
import pytest

from ffdstudio import InputError, read_mesh

SU2 = "NDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n{}\n{}\n{}\nNMARK= 0\n"


def su2(folder, *nodes):
    path = folder / "a.su2"
    path.write_text(SU2.format(*nodes))
    return read_mesh(path)


@pytest.mark.parametrize("extra", ["", " 7", " 7 12"])
def test_indices_behind_the_coordinates_are_fine(tmp_path, extra):
    mesh = su2(tmp_path, "0 0" + extra, "1 0" + extra, "0 1" + extra)
    assert mesh.points[:, :2].tolist() == [[0, 0], [1, 0], [0, 1]]


def test_halo_nodes_may_have_an_index_more(tmp_path):
    path = tmp_path / "a.su2"
    path.write_text(SU2.replace("NPOIN= 3", "NPOIN= 3 2").format("0 0 0", "1 0 1", "0 1 2 9"))
    assert read_mesh(path).points[2].tolist() == [0, 1, 0]


@pytest.mark.parametrize(
    "nodes",
    [
        ("0 0 0", "1 1 0 1", "0 1 2"),
        ("0 0", "9 1 0", "0 1"),
        ("0 0 0", "1 0", "0 1 2"),
        ("0 0 0 0 5", "1 0 1 1 5", "0 1 2 2 5"),
        ("0 0 0", "1 0 0.5", "0 1 2"),
        ("0 0 0", "1 0 inf", "0 1 2"),
        ("0 0 0", "1 0 nan", "0 1 2"),
    ],
)
def test_another_number_of_numbers_names_the_line(tmp_path, nodes):
    with pytest.raises(InputError, match=r"a\.su2, line [5-7]: "):
        su2(tmp_path, *nodes)


def lengthened(path, line):
    """Put a number before one line of the file, which has the given beginning."""
    text = path.read_text().splitlines()
    k = next(k for k, old in enumerate(text) if old.split()[: len(line)] == line)
    words = text[k].split()
    text[k] = " ".join([*words[: len(line)], "7.5", *words[len(line) :]])
    path.write_text("\n".join([*text, ""]))


POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def written(path, kind, **options):
    cells = {"triangle": [[0, 1, 2]]} if kind in ("stl", "obj") else {"tetra": [[0, 1, 2, 3]]}
    meshio.Mesh(POINTS, cells).write(path, file_format=kind, **options)


@pytest.mark.parametrize(
    ("name", "kind", "line", "options"),
    [
        ("a.stl", "stl", ["vertex"], {}),
        ("a.msh", "gmsh22", ["2"], {"binary": False}),
        ("a.inp", "avsucd", ["2"], {}),
    ],
)
def test_other_formats_refuse_it_as_well(tmp_path, name, kind, line, options):
    path = tmp_path / name
    written(path, kind, **options)
    read_mesh(path)
    lengthened(path, line)
    with pytest.raises(InputError, match=rf"{name}, line \d+: "):
        read_mesh(path)


@pytest.mark.parametrize(
    ("extra", "fine"), [(0, True), (1, True), (3, True), (2, False), (5, False)]
)
def test_a_vertex_of_obj_may_have_a_weight_or_a_colour(tmp_path, extra, fine):
    path = tmp_path / "a.obj"
    tail = " 0.5" * extra
    path.write_text(f"v 0 0 0{tail}\nv 1 0 0{tail}\nv 0 1 0{tail}\nf 1 2 3\n")
    if fine:
        assert read_mesh(path).points[1].tolist() == [1, 0, 0]
    else:
        with pytest.raises(InputError, match="is not known"):
            read_mesh(path)
