"""Faces that cells share: compared with a sort of all of them, whatever the cells and threads."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import threads
from ffdstudio.meshes import Mesh
from ffdstudio.meshes.measures.faces import topology_of
from ffdstudio.meshes.pairing import ALONE, MANY, loop_partners, outer, partners
from ffdstudio.meshes.topology import FACES, skin
from tests.meshes.shapes import block

KINDS = ["tetra", "pyramid", "wedge", "hexahedron"]


def by_sorting(sides):
    """Partners of all faces by their sorted nodes: the slow twin."""
    faces = [tuple(sorted(row)) for nodes, table in sides for f in table for row in nodes[:, f]]
    places: dict[tuple, list[int]] = {}
    for number, face in enumerate(faces):
        places.setdefault(face, []).append(number)
    found = np.full(len(faces), ALONE)
    for same in places.values():
        if len(same) == 2:
            found[same] = same[::-1]
        elif len(same) > 2:
            found[same] = MANY
    return found


def random_sides(seed: int, nodes: int, count: int):
    """Cells of all types on few nodes: faces shared by none, one and many."""
    rng = np.random.default_rng(seed)
    sides = []
    for kind in KINDS:
        size = 1 + max(max(face) for face in FACES[kind])
        rows = np.stack([rng.permutation(nodes)[:size] for _ in range(count)])
        sides.append((rows.astype(rng.choice([np.int32, np.int64])), FACES[kind]))
    return sides


@pytest.mark.parametrize(("nodes", "count"), [(9, 2), (12, 40), (60, 300), (400, 900)])
def test_partners_are_those_of_a_sort(nodes, count):
    sides = random_sides(nodes, nodes, count)
    assert (partners(sides) == by_sorting(sides)).all()
    rows = [rows for of_cells in outer(sides) for rows in of_cells]
    lonely = np.flatnonzero(by_sorting(sides) == ALONE)
    starts = np.cumsum([0, *(len(n) for n, table in sides for _ in table)])
    found = np.concatenate([start + r for start, r in zip(starts, rows, strict=False)])
    assert found.tolist() == lonely.tolist()


def test_a_node_with_thousands_of_faces_is_no_trouble():
    """A fan around node 0, most of whose faces lie in one bucket."""
    ring = np.arange(1, 5001)
    fan = np.stack([0 * ring, ring, np.roll(ring, -1), 0 * ring + 5001], axis=1)
    sides = [(np.random.default_rng(1).permutation(fan), FACES["tetra"])]
    assert (partners(sides) == by_sorting(sides)).all()
    assert sum(map(len, outer(sides)[0])) == 2 * 5000


@pytest.mark.parametrize("cores", [1, 2, 3, 7])
def test_threads_do_not_change_what_is_found(monkeypatch, cores):
    _, nodes = block(17, 17, 17)
    monkeypatch.setattr(threads, "count", lambda: cores)
    sides = [(nodes, FACES["hexahedron"])]
    assert (partners(sides) == by_sorting(sides)).all()
    assert sum(map(len, outer(sides)[0])) == 6 * 17**2


def test_the_skin_of_a_block_is_its_six_sides():
    points, nodes = block(4, 4, 4)
    faces = skin({"hexahedron": nodes})
    assert list(faces) == ["triangle", "quad"] or list(faces) == ["quad"]
    rows = points[faces["quad"]]
    normal = np.cross(rows[:, 1] - rows[:, 0], rows[:, 2] - rows[:, 1])
    assert np.abs(normal.sum(axis=0)).max() < 1e-12
    assert len(faces["quad"]) == 6 * 16


def test_edges_of_a_plane_mesh_are_paired():
    cells = np.array([[0, 1, 2], [2, 1, 3]])
    sides = [(cells, ((0, 1), (1, 2), (2, 0)))]
    assert (partners(sides) == by_sorting(sides)).all()
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    faces = topology_of(Mesh(points, {"triangle": cells}, dimension=2)).faces
    assert (faces.neighbour >= 0).sum() == 1
    assert len(faces) == 5


def test_a_face_of_three_cells_is_an_outer_face_of_each():
    points = np.random.default_rng(0).random((6, 3))
    three = Mesh(points, {"tetra": [[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]]})
    faces = topology_of(three).faces
    assert len(faces) == 3 * 4
    assert (faces.neighbour == -1).all()


def test_loops_are_equal_whatever_their_size_and_direction():
    rng = np.random.default_rng(2)
    loops = [rng.permutation(12)[: rng.integers(3, 8)] for _ in range(200)]
    loops += [np.roll(loop[::-1], 2) for loop in loops[:90]] + loops[:5]
    nodes = np.concatenate(loops)
    offsets = np.concatenate([[0], np.cumsum([len(loop) for loop in loops])])
    places: dict[tuple, list[int]] = {}
    for number, loop in enumerate(loops):
        places.setdefault(tuple(sorted(loop)), []).append(number)
    wanted = np.full(len(loops), ALONE)
    for same in places.values():
        if len(same) == 2:
            wanted[same] = same[::-1]
        elif len(same) > 2:
            wanted[same] = MANY
    assert (loop_partners(nodes, offsets) == wanted).all()


def test_no_cells_have_no_faces():
    assert partners([]).tolist() == []
    assert outer([]) == []
    assert loop_partners(np.empty(0, dtype=np.int64), np.zeros(1, dtype=np.int64)).tolist() == []
