"""Sections of surfaces against what is known of them."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.meshes import read_mesh
from ffdstudio.meshes.airfoil import naca4
from ffdstudio.project.view.slices import measured, section_of
from ffdstudio.samples import sample

XZ = np.array([[1.0, 0, 0], [0, 0, 1]])
Y = np.array([0.0, 1, 0])


def extruded(section: np.ndarray, turn: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Surface of a section along y, turned nose up by degrees about the origin."""
    a = np.radians(turn)
    x, z = section.T
    flat = np.column_stack([x * np.cos(a) + z * np.sin(a), -x * np.sin(a) + z * np.cos(a)])
    n = len(flat)
    points = np.concatenate(
        [np.column_stack([flat[:, 0], np.full(n, y), flat[:, 1]]) for y in (0.0, 1.0)]
    )
    k = np.arange(n - 1)
    triangles = np.concatenate(
        [np.column_stack([k, k + 1, k + n]), np.column_stack([k + 1, k + 1 + n, k + n])]
    )
    return points, triangles


@pytest.mark.parametrize("turn", [0.0, 7.5, -12.0])
@pytest.mark.parametrize(("name", "camber"), [("0012", 0.0), ("2412", 0.02), ("4415", 0.04)])
def test_a_naca_section_has_its_chord_thickness_camber_and_angle(name, camber, turn):
    points, triangles = extruded(naca4(name, 301), turn)
    found = measured(section_of(points, triangles, 0.3 * Y, Y), XZ)
    assert found.chord == pytest.approx(1, abs=2e-3)
    assert found.thickness == pytest.approx(int(name[2:]) / 100, abs=2e-3)
    assert found.camber == pytest.approx(camber, abs=4e-3)  # across the chord, not the line
    assert found.angle == pytest.approx(turn, abs=0.3)  # the nose is the farthest point


def test_the_wing_tapers_from_root_to_tip():
    mesh = read_mesh(sample("wing_skin.vtu"))
    triangles = mesh.cells["triangle"]
    chords = [
        measured(section_of(mesh.points, triangles, y * Y, Y), XZ).chord for y in (0.1, 1.25, 2.4)
    ]
    assert chords == pytest.approx([1 - 0.2 * y for y in (0.1, 1.25, 2.4)], rel=5e-3)


def test_segments_lie_in_the_plane_and_close():
    mesh = read_mesh(sample("wing_skin.vtu"))
    segments = section_of(mesh.points, mesh.cells["triangle"], 1.1 * Y, Y)
    assert np.abs(segments[..., 1] - 1.1).max() < 1e-12
    ends, counts = np.unique(segments.reshape(-1, 3), axis=0, return_counts=True)
    assert set(counts) == {2}
    assert len(ends) == len(segments)


def test_beside_the_surface_and_of_too_little_there_is_no_section():
    mesh = read_mesh(sample("wing_skin.vtu"))
    nothing = section_of(mesh.points, mesh.cells["triangle"], 9 * Y, Y)
    assert nothing.shape == (0, 2, 3)
    assert measured(nothing, XZ) is None
