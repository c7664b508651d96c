"""Small meshes to run commands on."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.cli.main import main


def square_text(n: int = 8) -> str:
    """Unit square of n x n x 2 triangles, SU2, markers bottom and top."""
    nodes = [(i / n, j / n) for j in range(n + 1) for i in range(n + 1)]
    number = lambda i, j: j * (n + 1) + i  # noqa: E731
    cells = []
    for j in range(n):
        for i in range(n):
            a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
            cells += [(a, b, c), (a, c, d)]
    lines = ["NDIME= 2", f"NELEM= {len(cells)}"]
    lines += [f"5 {a} {b} {c}" for a, b, c in cells]
    lines += [f"NPOIN= {len(nodes)}", *(f"{x!r} {y!r}" for x, y in nodes), "NMARK= 2"]
    for name, j in (("bottom", 0), ("top", n)):
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {n}"]
        lines += [f"3 {number(i, j)} {number(i + 1, j)}" for i in range(n)]
    return "\n".join([*lines, ""])


def cube_text(x0: float = 0.0, n: int = 3, symmetry: bool = False) -> str:
    """Unit cube from x0 on, six tetrahedra a cell, SU2; if wanted with a marker at y = 0."""
    m = n + 1
    nodes = [(x0 + i / n, j / n, k / n) for k in range(m) for j in range(m) for i in range(m)]
    cells = []
    for base in np.ndindex(n, n, n):
        for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            corner, path = np.array(base), [np.array(base)]
            for axis in order:
                corner = corner + np.eye(3, dtype=int)[axis]
                path.append(corner)
            cells.append([int(p[0] + m * (p[1] + m * p[2])) for p in path])
    lines = ["NDIME= 3", f"NELEM= {len(cells)}", *("10 " + " ".join(map(str, c)) for c in cells)]
    lines += [f"NPOIN= {len(nodes)}", *(" ".join(map(repr, p)) for p in nodes)]
    faces = [f for c in cells for f in combinations(c, 3) if all(nodes[k][1] == 0 for k in f)]
    lines += [f"NMARK= {int(symmetry)}"]
    if symmetry:
        lines += ["MARKER_TAG= SYMMETRY", f"MARKER_ELEMS= {len(faces)}"]
        lines += ["5 " + " ".join(map(str, face)) for face in faces]
    lines += [""]
    return "\n".join(lines)


@pytest.fixture
def square(tmp_path: Path) -> Path:
    """A 2D mesh file."""
    path = tmp_path / "square.su2"
    path.write_text(square_text())
    return path


@pytest.fixture
def cube(tmp_path: Path) -> Path:
    """A 3D mesh file."""
    path = tmp_path / "cube.su2"
    path.write_text(cube_text())
    return path


@pytest.fixture
def half(tmp_path: Path) -> Path:
    """A 3D mesh file whose face y = 0 is a symmetry plane."""
    path = tmp_path / "half.su2"
    path.write_text(cube_text(n=4, symmetry=True))
    return path


@pytest.fixture
def cubes(tmp_path: Path) -> list[Path]:
    """Two cubes, in separate files, that share a face."""
    paths = [tmp_path / "left.su2", tmp_path / "right.su2"]
    for path, x0 in zip(paths, (0.0, 1.0), strict=True):
        path.write_text(cube_text(x0))
    return paths


class Command:
    """`ffdstudio` called in this process."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self.capsys = capsys
        self.out = self.err = ""

    def __call__(self, *words: object) -> int:
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:  # --help and --version
            code = int(end.code or 0)
        self.out, self.err = self.capsys.readouterr()
        return code

    def json(self, *words: object) -> dict:
        """Call with --json; stdout must be one object and nothing else."""
        self.code = self(*words, "--json")
        return json.loads(self.out)


@pytest.fixture
def ffdstudio(capsys: pytest.CaptureFixture[str]) -> Command:
    """Call a command: returns the exit code, `out` and `err` hold what it printed."""
    return Command(capsys)
