"""Motion of walls for a solver's own deformation: the formats, and OpenFOAM itself."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.errors import InputError
from ffdstudio.exchange.solver_motion import write_solver_motion
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.meshes.measures.faces import topology_of
from ffdstudio.samples import sample

HEAD = 'FoamFile {{ version 2.0; format ascii; class {}; location "{}"; object {}; }}\n'
ETC = Path("/usr/share/openfoam")
CELLS = (4, 3, 1)
TYPES = {
    "floor": "wall", "top": "patch", "left": "patch", "right": "patch",
    "front": "empty", "back": "empty",
}  # fmt: skip


def grid() -> tuple[np.ndarray, np.ndarray]:
    axes = [np.linspace(0, 1, n + 1) for n in CELLS]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    i = np.arange(len(points)).reshape([n + 1 for n in CELLS])
    low, high = slice(None, -1), slice(1, None)
    around = [(low, low), (high, low), (high, high), (low, high)]
    cells = np.stack([i[a, b, c].ravel() for c in (low, high) for a, b in around], axis=-1)
    return points, cells


def write_case(case: Path, types: dict[str, str] = TYPES) -> None:
    """A box of hexahedra with a patch on each side."""
    points, cells = grid()
    faces = topology_of(Mesh(points, {"hexahedron": cells})).faces
    loops = np.split(faces.nodes, faces.offsets[1:-1])
    owner, neighbour = faces.owner.copy(), faces.neighbour.copy()
    inner = np.flatnonzero(neighbour >= 0)
    for f in inner[owner[inner] > neighbour[inner]]:
        owner[f], neighbour[f], loops[f] = neighbour[f], owner[f], loops[f][::-1]
    inner = inner[np.lexsort((neighbour[inner], owner[inner]))]
    sides = {"floor": (1, 0), "top": (1, 1), "left": (0, 0), "right": (0, 1)}
    sides |= {"front": (2, 0), "back": (2, 1)}
    order, entries = list(inner), []
    for name, (axis, value) in sides.items():
        own = [f for f in np.flatnonzero(neighbour < 0) if (points[loops[f], axis] == value).all()]
        entries.append(
            f"{name} {{ type {types[name]}; nFaces {len(own)}; startFace {len(order)}; }}"
        )
        order += own
    rows = {
        "points": ("vectorField", ["({:.17g} {:.17g} {:.17g})".format(*p) for p in points]),
        "faces": ("faceList", [f"4({' '.join(map(str, loops[f]))})" for f in order]),
        "owner": ("labelList", [str(owner[f]) for f in order]),
        "neighbour": ("labelList", [str(neighbour[f]) for f in inner]),
        "boundary": ("polyBoundaryMesh", entries),
    }
    folder = case / "constant" / "polyMesh"
    folder.mkdir(parents=True)
    for name, (kind, lines) in rows.items():
        text = f"{len(lines)}\n(\n" + "\n".join(lines) + "\n)\n"
        (folder / name).write_text(HEAD.format(kind, "constant/polyMesh", name) + text)


def raised(mesh: Mesh, marker: str = "floor") -> np.ndarray:
    points, nodes = mesh.points.copy(), mesh.marker_nodes(marker)
    points[nodes, 1] += 0.1 * np.sin(np.pi * points[nodes, 0])
    return points


def entries(path: Path) -> dict[str, str]:
    """What the file says of each patch."""
    text = path.read_text()
    body = text[text.index("boundaryField\n{\n") + 16 :]
    return dict(re.findall(r"^(\w+)\n\{\n(.*?)\n\}", body, re.S | re.M))


def test_su2_gets_the_new_place_of_each_node_of_the_walls(tmp_path):
    mesh = read_mesh(sample("naca0012.su2"))
    nodes = mesh.marker_nodes("airfoil")
    points = raised(mesh, "airfoil") + [0, 1, 0]  # others do not count
    write_solver_motion(mesh, tmp_path / "motion.dat", points, ["airfoil"])
    rows = [line.split(" ") for line in (tmp_path / "motion.dat").read_text().splitlines()]
    assert [int(row[0]) for row in rows] == nodes.tolist()
    assert np.array_equal([[float(v) for v in row[1:]] for row in rows], points[nodes, :2])


def test_a_space_mesh_of_su2_has_three_coordinates(tmp_path):
    mesh = read_mesh(sample("wing_air.su2"))
    write_solver_motion(mesh, tmp_path / "motion.dat", mesh.points, ["WING"])
    assert {len(line.split()) for line in (tmp_path / "motion.dat").read_text().splitlines()} == {4}


def test_openfoam_gets_displacements_in_the_order_of_the_patch(tmp_path):
    write_case(tmp_path / "case")
    mesh = read_mesh(tmp_path / "case")
    points = raised(mesh)
    target = tmp_path / "case" / "0" / "pointDisplacement"
    write_solver_motion(mesh, target, points, ["floor"], ["left"])
    found = entries(target)
    assert set(found) == set(TYPES)
    assert found["front"] == "type empty;"
    assert found["left"] == "type slip;"
    assert found["right"] == found["top"] == "type fixedValue;\nvalue uniform (0 0 0);"
    rows = re.findall(r"^\((.*)\)$", found["floor"], re.M)
    met: list[int] = []  # points as the patch's faces first meet them
    for line in re.findall(r"4\((.*)\)", (tmp_path / "case/constant/polyMesh/faces").read_text()):
        loop = [int(n) for n in line.split()]
        if np.isin(loop, mesh.marker_nodes("floor")).all():
            met += [n for n in loop if n not in met]
    assert f"\n{len(met)}\n(" in found["floor"]
    assert np.array_equal(
        [[float(v) for v in row.split()] for row in rows], (points - mesh.points)[met]
    )


def test_what_has_no_such_file_is_refused(tmp_path):
    nodes = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    mesh = Mesh(nodes, {"triangle": [[0, 1, 2]]}, {"w": {"line": [[0, 1]]}}, dimension=2)
    with pytest.raises(InputError, match="SU2 and OpenFOAM"):
        write_solver_motion(mesh, tmp_path / "m", mesh.points, ["w"])


def test_a_motion_without_walls_and_unknown_ones_are_refused(tmp_path):
    mesh = read_mesh(sample("naca0012.su2"))
    for walls, cause in (([], "no wall moves"), (["hull"], "no marker hull")):
        with pytest.raises(InputError, match=cause):
            write_solver_motion(mesh, tmp_path / "m", mesh.points, walls)


def test_several_zones_are_refused(tmp_path):
    zone = "NDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n0 0\n1 0\n0 1\nNMARK= 1\nMARKER_TAG= w\n"
    zone += "MARKER_ELEMS= 1\n3 0 1\n"
    path = tmp_path / "zones.su2"
    path.write_text(f"NZONE= 2\nIZONE= 1\n{zone}IZONE= 2\n{zone}")
    mesh = read_mesh(path)
    with pytest.raises(InputError, match="one zone only, this file has 2"):
        write_solver_motion(mesh, tmp_path / "m", mesh.points, mesh.boundaries[:1])


@pytest.mark.skipif(
    shutil.which("moveDynamicMesh") is None or not ETC.is_dir(), reason="needs Debian's openfoam"
)
def test_openfoam_moves_the_walls_where_they_were_told_to_go(tmp_path):
    case = tmp_path / "case"
    write_case(case)
    mesh = read_mesh(case)
    points = raised(mesh)
    write_solver_motion(mesh, case / "0" / "pointDisplacement", points, ["floor"])
    (case / "system").mkdir()
    settings = {
        "controlDict": "application moveDynamicMesh; startFrom startTime; startTime 0; stopAt "
        "endTime; endTime 1; deltaT 1; writeControl timeStep; writeInterval 1; writePrecision 17;",
        "fvSchemes": "ddtSchemes { default Euler; } gradSchemes { default Gauss linear; } "
        "divSchemes { default none; } laplacianSchemes { default Gauss linear corrected; } "
        "interpolationSchemes { default linear; } snGradSchemes { default corrected; }",
        "fvSolution": 'solvers { "cellDisplacement.*" { solver PCG; preconditioner DIC; '
        "tolerance 1e-12; relTol 0; } }",
    }
    for name, text in settings.items():
        (case / "system" / name).write_text(HEAD.format("dictionary", "system", name) + text)
    (case / "constant/dynamicMeshDict").write_text(
        HEAD.format("dictionary", "constant", "dynamicMeshDict")
        + "dynamicFvMesh dynamicMotionSolverFvMesh; motionSolverLibs (fvMotionSolvers); "
        "solver displacementLaplacian; displacementLaplacianCoeffs { diffusivity uniform; }"
    )
    done = subprocess.run(
        ["moveDynamicMesh", "-case", str(case)],
        capture_output=True, text=True, check=False, timeout=120,
        env={**os.environ, "WM_PROJECT_DIR": str(ETC)},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    moved = case / "1" / "polyMesh" / "points"
    rows = re.findall(r"^\(([^()]*)\)$", moved.read_text(), re.M)
    got = np.array([row.split() for row in rows], dtype=float)
    nodes = mesh.marker_nodes("floor")
    assert np.abs(got[nodes] - points[nodes]).max() < 1e-12
    held = mesh.marker_nodes("top")
    assert np.abs(got[held] - mesh.points[held]).max() < 1e-12
    assert np.abs(got - mesh.points).max() > 0.05
