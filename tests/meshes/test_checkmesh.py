"""Measures of faces against OpenFOAM's checkMesh 1912, kept figures and the program itself.

The kept figures come from ``checkMesh -allGeometry -writeAllFields`` with 17 digits: cell fields
of a distorted block of hexahedra and of the dual (polyDualMesh) of a tetrahedral mesh, and the
summary for airFoil2D.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.meshes import Faces, Mesh, quality
from ffdstudio.meshes.measures.faces import topology_of
from tests.meshes.shapes import block

FIELDS = {
    "non_orthogonality": "nonOrthoAngle",
    "face_skewness": "skewness",
    "aspect_ratio": "aspectRatio",
    "volume": "cellVolume",
}
AIRFOIL = {
    "non_orthogonality": 41.623700160649584,
    "face_skewness": 0.98330555826372967,
    "aspect_ratio": 98.768057280236704,
}
AIRFOIL_VOLUMES = 0.00085510993750000748, 35.425903000000041, 10564.526774550985


def same(ours, theirs):
    """Ten digits; an angle of nearly 0 is known to the root of that only, by its cosine."""
    assert ours == pytest.approx(theirs, rel=1e-10, abs=1e-10 * np.abs(theirs).max())


@pytest.mark.parametrize("name", ["hexahedra", "polyhedra"])
def test_fields_of_cells_have_ten_digits_of_checkmesh(root, name):
    data = np.load(root / f"tests/meshes/data/checkmesh_{name}.npz")
    parts = (data[k].astype(np.int64) for k in ("nodes", "offsets", "owner", "neighbour"))
    report = quality(Mesh(data["points"], faces=Faces(*parts)))
    for measure in FIELDS:
        same(report.measures[measure], data[measure])


def test_the_tutorial_airfoil_has_ten_digits_of_checkmesh(shared):
    mesh = ffd.read_mesh(shared / "meshes/openfoam/airFoil2D")
    report = quality(mesh)
    for measure, most in AIRFOIL.items():
        assert report.statistics(measure).max == pytest.approx(most, rel=1e-10)
    volumes = report.measures["volume"]
    found = volumes.min(), volumes.max(), volumes.sum()
    assert found == pytest.approx(AIRFOIL_VOLUMES, rel=1e-10)
    assert report.solver_tests["OpenFOAM wrong face pyramids"] == 0


def test_wrong_face_pyramids_are_counted_like_checkmesh(root):
    data = np.load(root / "tests/meshes/data/checkmesh_polyhedra.npz")
    parts = (data[k].astype(np.int64) for k in ("nodes", "offsets", "owner", "neighbour"))
    report = quality(Mesh(data["points"], faces=Faces(*parts)))
    assert report.solver_tests["OpenFOAM wrong face pyramids"] == 162


# ---- the program itself ---------------------------------------------------------------------

HEAD = 'FoamFile {{ version 2.0; format ascii; class {}; location "{}"; object {}; }}\n'
ETC = Path("/usr/share/openfoam")


def write_case(case, points, faces):
    """Write a polyMesh with one wall patch, faces in OpenFOAM's order."""
    loops = np.split(faces.nodes, faces.offsets[1:-1])
    owner, neighbour = faces.owner.copy(), faces.neighbour.copy()
    inner = np.flatnonzero(neighbour >= 0)
    for f in inner[owner[inner] > neighbour[inner]]:
        owner[f], neighbour[f], loops[f] = neighbour[f], owner[f], loops[f][::-1]
    inner = inner[np.lexsort((neighbour[inner], owner[inner]))]
    outer = np.flatnonzero(neighbour < 0)
    order = [*inner, *outer[np.argsort(owner[outer], kind="stable")]]
    rows = {
        "points": ("vectorField", ["({:.17g} {:.17g} {:.17g})".format(*p) for p in points]),
        "faces": ("faceList", [f"{len(loops[f])}({' '.join(map(str, loops[f]))})" for f in order]),
        "owner": ("labelList", [str(owner[f]) for f in order]),
        "neighbour": ("labelList", [str(neighbour[f]) for f in inner]),
        "boundary": (
            "polyBoundaryMesh",
            [f"walls {{ type wall; nFaces {len(outer)}; startFace {len(inner)}; }}"],
        ),
    }
    folder = case / "constant" / "polyMesh"
    folder.mkdir(parents=True)
    for name, (kind, lines) in rows.items():
        text = f"{len(lines)}\n(\n" + "\n".join(lines) + "\n)\n"
        (folder / name).write_text(HEAD.format(kind, "constant/polyMesh", name) + text)
    write_system(case)


def write_system(case):
    """Write the dictionaries that checkMesh wants to see."""
    (case / "system").mkdir(exist_ok=True)
    settings = {
        "controlDict": "application checkMesh; startFrom startTime; startTime 0; stopAt endTime;"
        "endTime 1; deltaT 1; writeControl timeStep; writeInterval 1; writePrecision 17;",
        "fvSchemes": "ddtSchemes {} gradSchemes {} divSchemes {} laplacianSchemes {}"
        "interpolationSchemes {} snGradSchemes {}",
        "fvSolution": "",
    }
    for name, text in settings.items():
        (case / "system" / name).write_text(HEAD.format("dictionary", "system", name) + text)


def field(case, name):
    """Cell values that checkMesh wrote."""
    text = (case / "constant" / name).read_text()
    found = re.search(r"internalField\s+nonuniform[^(]*\(([^)]*)\)", text)
    return np.array(found[1].split(), dtype=float)


@pytest.mark.skipif(
    shutil.which("checkMesh") is None or not ETC.is_dir(), reason="needs Debian's openfoam"
)
@pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
def test_the_program_says_the_same_of_a_mesh_made_now(tmp_path, kind):
    points, cells = block(4, 3, 3)
    points += 0.04 * np.random.default_rng().normal(size=points.shape)
    if kind == "tetra":
        kuhn = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
        cells = cells[:, kuhn].reshape(-1, 4)
    mesh = Mesh(points, {kind: cells})
    write_case(tmp_path, points, topology_of(mesh).faces)
    subprocess.run(
        ["checkMesh", "-constant", "-allGeometry", "-writeAllFields"],
        cwd=tmp_path,
        env={**os.environ, "WM_PROJECT_DIR": str(ETC)},
        check=True,
        capture_output=True,
        timeout=60,
    )
    report = quality(mesh)
    for measure, name in FIELDS.items():
        same(report.measures[measure], field(tmp_path, name))
