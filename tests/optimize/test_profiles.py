"""Sections in plane meshes are found, and put in Selig's order."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.meshes import Mesh
from ffdstudio.meshes.airfoil import contour_mesh, naca4
from ffdstudio.optimize.geometry.profiles import profiles


def _with_markers(contour, shuffle):
    """Plane mesh whose boundary elements come in any order and direction."""
    closed = np.allclose(contour[0], contour[-1])
    ring = contour[:-1] if closed else contour
    n, order = len(ring), shuffle.permutation(len(ring))
    circle = 20 * np.column_stack([np.cos(np.arange(32) / 5.1), np.sin(np.arange(32) / 5.1)])
    points = np.vstack([ring, circle])
    place = np.empty(n, dtype=int)
    place[order] = np.arange(n)
    points[:n] = ring[order]
    lines = np.column_stack([place, np.roll(place, -1)])
    flip = shuffle.random(n) < 0.5
    lines[flip] = lines[flip, ::-1]
    far = np.column_stack([np.arange(32), (np.arange(32) + 1) % 32]) + n
    xyz = np.column_stack([points, np.zeros(len(points))])
    markers = {"far": {"line": far}, "foil": {"line": shuffle.permutation(lines)}}
    return Mesh(xyz, {"triangle": [[0, 1, n]]}, markers, dimension=2)


@pytest.mark.parametrize("closed", [True, False])
def test_a_marker_is_put_in_seligs_order_whatever_the_order_of_its_lines(closed):
    contour = naca4("2412", points=41, closed=closed)
    mesh = _with_markers(contour, np.random.default_rng(3))
    (found,) = profiles(mesh)
    assert found.marker == "foil"
    assert np.array_equal(mesh.points[found.nodes, :2], contour)


def test_the_lines_of_an_airfoil_file_are_a_section():
    (found,) = profiles(contour_mesh(naca4("0012", points=21, closed=False)))
    assert found.marker == ""
    assert len(found.nodes) == 41
