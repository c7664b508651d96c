"""A lattice that works at once: room, seat, and how far the skin can move in it."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio.engine import Lattice, embed
from ffdstudio.meshes import inverted, read_mesh, safe_amplitude
from ffdstudio.project.placing.estimate import influence, leading, reaches
from ffdstudio.project.placing.placement import Site, free_points, placed
from ffdstudio.project.placing.reach import skin_reach
from ffdstudio.samples import sample


@pytest.fixture(scope="module")
def naca():
    mesh = read_mesh(sample("naca0012.su2"))
    return mesh, Site.of_mesh(mesh, ["airfoil"])


def dragged(mesh, lattice, point, vector):
    net = lattice.control_points.copy()
    net[point] += vector
    return embed(lattice, mesh.points).deform(lattice.moved(net))


@pytest.mark.parametrize("shape", [(6, 4), (8, 6), (4, 4), (5, 3)])
def test_naca0012_in_its_default_lattice_moves_its_skin_by_8_percent_of_the_chord(naca, shape):
    mesh, site = naca
    found = placed(site, shape)
    free = free_points(found.lattice, found.frozen, found.planes)
    assert found.frozen == 1
    value = np.where(free, influence(found.lattice, site.skin), 0)
    skin = mesh.marker_nodes("airfoil")
    for point in map(tuple, np.argwhere(leading(value))):
        for way in ([0, 1, 0], [0, -1, 0], [1, 0, 0], [-1, 0, 0]):
            step = np.array(way) * 0.08 / value[point]
            points = dragged(mesh, found.lattice, point, step)
            assert np.linalg.norm(points - mesh.points, axis=1)[skin].max() >= 0.08 - 1e-3
            assert inverted(mesh, points).count == 0


def test_the_reach_is_where_the_first_cell_inverts(naca):
    mesh, site = naca
    found = placed(site, (6, 4))
    reach, least = found.reach(site), np.inf
    free = free_points(found.lattice, found.frozen, found.planes)
    value = np.where(free, influence(found.lattice, site.skin), 0)
    for point in map(tuple, np.argwhere(leading(value))):
        for way in ([0, 1, 0], [0, -1, 0], [1, 0, 0], [-1, 0, 0]):
            move = dragged(mesh, found.lattice, point, way) - mesh.points
            least = min(least, safe_amplitude(mesh, move) * value[point])
    assert reach == pytest.approx(least, rel=1e-6)


@pytest.mark.parametrize("margin", [0.02, 0.1, 0.3])
def test_the_estimate_is_below_what_the_cells_allow_and_near_it(naca, margin):
    _, site = naca
    found = placed(site, (6, 4), margin=margin)
    free = free_points(found.lattice, found.frozen, found.planes)
    estimate = reaches(found.lattice, free, site.skin).min()
    assert 0.6 * found.reach(site) < estimate < 1.05 * found.reach(site)


def test_a_margin_counts_from_the_largest_extent_in_every_direction(naca):
    _, site = naca
    low, high = placed(site, (6, 4), margin=0.25).lattice.domain.T
    assert np.allclose(low, site.skin.min(axis=0)[:2] - 0.25)
    assert np.allclose(high, site.skin.max(axis=0)[:2] + 0.25)
    low, high = placed(site, (6, 4), margin=[0.1, 0.4]).lattice.domain.T
    assert np.allclose(high - site.skin.max(axis=0)[:2], [0.1, 0.4])


def test_the_wing_can_move_by_its_thickness_and_begins_at_its_symmetry_plane():
    mesh = read_mesh(sample("wing_air.su2"))
    site = Site.of_mesh(mesh, ["WING"])
    found = placed(site, (6, 4, 4))
    assert found.planes == {(1, 0): "SYMMETRY"}
    assert np.ptp(site.skin[:, 2]) <= found.wanted < 0.14
    assert found.reach(site) >= found.wanted


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_room_and_reach_go_with_the_scale(naca, scale):
    mesh, site = naca
    big = mesh.with_points(mesh.points * scale)
    other = Site.of_mesh(big, ["airfoil"])
    a, b = placed(site, (6, 4)), placed(other, (6, 4))
    assert np.allclose(a.room, b.room)
    assert b.reach(other) == pytest.approx(scale * a.reach(site), rel=1e-6)


def test_a_skin_that_no_free_point_moves_has_no_reach(naca):
    mesh, site = naca
    box = Lattice.box([5, 5], [6, 6], (4, 4))
    free = np.ones((4, 4), dtype=bool)
    assert skin_reach(box, free, site.skin, [(mesh, mesh.points)]) == 0
