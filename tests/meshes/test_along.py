"""The first inversion along a path, against dense looking."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.engine import Lattice, embed
from ffdstudio.meshes import Mesh, inverted
from ffdstudio.meshes.safety.along import first_inversion


def grid(n: int = 6) -> Mesh:
    """Plane unit square of triangles."""
    at = np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1)] * 2, indexing="ij"), -1).reshape(-1, 2)
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    cells = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(np.column_stack([at, np.zeros(len(at))]), {"triangle": cells}, dimension=2)


def turning(mesh: Mesh):
    """Nodes while the inner control points of a lattice turn about the middle, by degrees."""
    box = Lattice.box([-0.1, -0.1], [1.1, 1.1], (5, 5))
    embedding, inner = embed(box, mesh.points), np.s_[1:-1, 1:-1]

    def at(degrees: float) -> np.ndarray:
        a = np.radians(degrees)
        turn = np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]])
        net = box.control_points.copy()
        net[inner] = (net[inner] - [0.5, 0.5, 0]) @ turn + [0.5, 0.5, 0]
        return embedding.deform(box.moved(net))

    return at


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("safe", [0.0, 20.0])
def test_a_rotation_ends_where_dense_looking_finds_the_first_inverted_cell(sign, safe):
    mesh, asked = grid(), sign * 170.0
    at = turning(mesh)
    found = first_inversion(mesh, at, asked, sign * safe, step=4.0)
    assert 20 < sign * found < 170
    counts = [inverted(mesh, at(found * share)).count for share in np.linspace(0, 1 - 1e-6, 60)]
    assert max(counts) == 0
    assert inverted(mesh, at(found * (1 + 1e-6))).count > 0


def test_a_path_that_stays_safe_has_no_end():
    mesh = grid()
    assert first_inversion(mesh, turning(mesh), 10.0, step=4.0) == np.inf
    assert first_inversion(mesh, turning(mesh), -10.0, step=4.0) == -np.inf


def test_a_straight_path_is_one_piece():
    mesh, asked = grid(), []

    def at(s: float) -> np.ndarray:
        asked.append(s)
        return mesh.points * [1 - s, 1, 1]

    assert first_inversion(mesh, at, 3.0) == pytest.approx(1.0)
    assert len(asked) < 8
