"""How cells hang together: counted as OpenFOAM's checkMesh counts, on meshes broken on purpose."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.cli.main import main
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.meshes.measures.faces import topology_of
from ffdstudio.meshes.measures.topology_checks import connections
from ffdstudio.meshes.topology import FACES
from tests.meshes.shapes import block
from tests.meshes.test_checkmesh import ETC, HEAD, write_system

BRICK = FACES["hexahedron"]


class Case:
    """Faces, owners and neighbours as they are to be written, good to begin with."""

    def __init__(self, points, cells):
        found = topology_of(Mesh(points, {"hexahedron": cells})).faces
        loops = np.split(found.nodes, found.offsets[1:-1])
        rows = [
            (o, n, loop.tolist()) if n < 0 or o < n else (n, o, loop[::-1].tolist())
            for o, n, loop in zip(
                found.owner.tolist(), found.neighbour.tolist(), loops, strict=True
            )
        ]
        self.points = points
        self.rows = sorted(rows, key=lambda row: (row[1] < 0, row[0], row[1]))

    @property
    def inner(self):
        return sum(n >= 0 for _, n, _ in self.rows)

    def write(self, folder: Path) -> Path:
        inner = self.inner
        rows = {
            "points": ("vectorField", [f"({x!r} {y!r} {z!r})" for x, y, z in self.points.tolist()]),
            "faces": ("faceList", [f"{len(x)}({' '.join(map(str, x))})" for _, _, x in self.rows]),
            "owner": ("labelList", [str(o) for o, _, _ in self.rows]),
            "neighbour": ("labelList", [str(n) for _, n, _ in self.rows if n >= 0]),
            "boundary": (
                "polyBoundaryMesh",
                [f"walls {{ type wall; nFaces {len(self.rows) - inner}; startFace {inner}; }}"],
            ),
        }
        poly = folder / "constant" / "polyMesh"
        poly.mkdir(parents=True)
        for name, (kind, lines) in rows.items():
            text = f"{len(lines)}\n(\n" + "\n".join(lines) + "\n)\n"
            (poly / name).write_text(HEAD.format(kind, "constant/polyMesh", name) + text)
        write_system(folder)
        return folder


def good():
    return Case(*block(3, 3, 3))


def unused_points():
    case = good()
    case.points = np.vstack([case.points, np.full((3, 3), 5.0)])
    return case


def faces_out_of_order():
    case = good()
    case.rows[0], case.rows[3] = case.rows[3], case.rows[0]
    return case


def owner_above_neighbour():
    case = good()
    owner, neighbour, loop = case.rows[4]
    case.rows[4] = neighbour, owner, loop[::-1]
    return case


def two_regions():
    points, cells = block(3, 3, 3)
    return Case(np.vstack([points, points + [3, 0, 0]]), np.vstack([cells, cells + len(points)]))


def joined_by_an_edge():
    points, cells = block(2, 2, 1)
    case = Case(points, cells[[0, 3]])
    used = np.unique(np.concatenate([loop for *_, loop in case.rows]))
    case.points = points[used]
    case.rows = [(o, n, np.searchsorted(used, x).tolist()) for o, n, x in case.rows]
    return case


def a_hole():
    case = good()
    del case.rows[case.inner + 2]
    return case


def two_holes():
    case = a_hole()
    del case.rows[case.inner + 20]
    return case


def a_baffle():
    case = good()
    owner, neighbour, loop = case.rows.pop(5)
    case.rows += [(owner, -1, loop), (neighbour, -1, loop[::-1])]
    return case


def a_face_twice():
    case = good()
    case.rows.append(case.rows[case.inner + 1])
    return case


def a_cell_twice():
    case = good()
    first = len(case.points)
    corner = case.points[[0, 16, 20, 4, 1, 17, 21, 5]]
    case.points = np.vstack([case.points, corner + [4, 0, 0]])
    for cell in (27, 28):
        case.rows += [(cell, -1, [first + k for k in face]) for face in BRICK]
    return case


def all_at_once():
    case = two_regions()
    case.points = np.vstack([case.points, np.full((2, 3), 9.0)])
    case.rows[0], case.rows[3] = case.rows[3], case.rows[0]
    case.rows.append(case.rows[case.inner])
    return case


BROKEN = [
    unused_points,
    faces_out_of_order,
    owner_above_neighbour,
    two_regions,
    joined_by_an_edge,
    a_hole,
    two_holes,
    a_baffle,
    a_face_twice,
    a_cell_twice,
    all_at_once,
]
EXPECTED = {  # what is not 0, one region and in order
    "unused_points": {"unused_points": 3},
    "faces_out_of_order": {},
    "owner_above_neighbour": {},
    "two_regions": {"regions": 2},
    "joined_by_an_edge": {"regions": 2, "non_manifold_edges": 1},
    "a_hole": {"open_cells": 1},
    "two_holes": {"open_cells": 2},
    "a_baffle": {"duplicate_faces": 1},
    "a_face_twice": {"duplicate_faces": 1, "open_cells": 1},
    "a_cell_twice": {"duplicate_faces": 6, "duplicate_cells": 1, "regions": 3},
    "all_at_once": {"unused_points": 2, "duplicate_faces": 1, "regions": 2, "open_cells": 1},
}


@pytest.mark.parametrize("make", BROKEN)
def test_what_is_broken_is_counted(tmp_path, make):
    found = connections(read_mesh(make().write(tmp_path / "case"))).to_dict()
    wanted = {
        "unused_points": 0,
        "duplicate_faces": 0,
        "duplicate_cells": 0,
        "open_cells": 0,
        "regions": 1,
    } | EXPECTED[make.__name__]
    if "non_manifold_edges" not in wanted and make in (a_baffle, a_face_twice, a_cell_twice):
        assert found.pop("non_manifold_edges") > 0
    elif make is all_at_once:
        assert found.pop("non_manifold_edges") == 4
    else:
        assert found.pop("non_manifold_edges") == wanted.pop("non_manifold_edges", 0)
    disorder = make in (faces_out_of_order, owner_above_neighbour, all_at_once)
    assert (found.pop("unordered_faces") > 0) == disorder
    assert found == wanted


def said(text: str, pattern: str) -> int:
    """Number in a line of checkMesh, 0 if there is no such line."""
    match = re.search(pattern, text)
    return int(match[1]) if match else 0


@pytest.mark.skipif(
    shutil.which("checkMesh") is None or not ETC.is_dir(), reason="needs Debian's openfoam"
)
@pytest.mark.parametrize("make", [good, *BROKEN])
def test_checkmesh_says_the_same(tmp_path, make):
    case = make().write(tmp_path / "case")
    text = subprocess.run(
        ["checkMesh", "-constant", "-allTopology"],
        cwd=case,
        env={**os.environ, "WM_PROJECT_DIR": str(ETC)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    ).stdout
    found = connections(read_mesh(case))
    assert "Checking topology" in text
    assert found.unused_points == said(text, r"number unused by cells: (\d+)")
    assert found.duplicate_faces == said(text, r"identical duplicate faces[^:]*: (\d+)")
    assert found.regions == said(text, r"Number of regions: (\d+)")
    assert bool(found.unordered_faces) == ("Faces not in upper triangular order" in text)
    assert bool(found.non_manifold_edges) == ("multiply connected (shared edge)" in text)
    opened = said(text, r"Open cells found, number of cells: (\d+)")  # by edges that are used once
    assert found.open_cells == (opened or said(text, r"number of open cells (\d+)"))


def test_a_mesh_of_cells_is_checked_as_well():
    points, cells = block(2, 2, 1)
    apart = Mesh(np.vstack([points, [[9, 9, 9]]]), {"hexahedron": cells[[0, 3, 3]]})
    found = connections(apart)
    assert found.unused_points == len(points) - 14 + 1
    assert (found.duplicate_cells, found.regions, found.unordered_faces) == (1, 2, None)
    three = Mesh(np.eye(5)[:, :3], {"tetra": [[0, 1, 2, 3], [0, 1, 2, 4], [2, 1, 0, 3]]})
    assert connections(three).duplicate_faces == 2
    assert connections(three).duplicate_cells == 1


def test_edges_of_three_triangles_and_islands_of_a_surface():
    points = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [5, 0, 0], [6, 0, 0], [5, 1, 0]]
    )
    book = Mesh(points, {"triangle": [[0, 1, 2], [0, 1, 3], [0, 1, 4], [5, 6, 7]]})
    found = connections(book)
    assert found.non_manifold_edges == 1
    assert found.unused_points == 0
    plane = Mesh(points * [1, 1, 0], {"triangle": [[0, 1, 2], [5, 6, 7]]}, dimension=2)
    assert connections(plane).regions == 2


def test_quality_tells_the_topology(tmp_path, capsys):
    case = all_at_once().write(tmp_path / "case")
    assert main(["quality", str(case)]) == 0
    out = capsys.readouterr().out
    assert "topology as checkMesh has it: 2 unused points, 1 duplicate faces, 1 open cells" in out
    assert main(["quality", str(case), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["topology"]
    assert told["regions"] == 2
    assert told["open_cells"] == 1
