"""Volume inside a surface: the same wherever it lies, and closed where it is open in a plane."""

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh
from ffdstudio.meshes.surfaces import open_loops, oriented
from ffdstudio.optimize.constraints import Volume
from ffdstudio.optimize.geometry.surfaces import triangles_of
from ffdstudio.samples import sample

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
FULL = np.array([part for a, b, c, d in QUADS for part in ([a, b, c], [a, c, d])])
OFFSETS = ([0, 0, 0], [0, 10, 0], [-3, 1e4, 7], [1e6, 0, 0])


def turned(triangles, seed=0):
    """Some of the triangles turned over."""
    out = triangles.copy()
    rows = np.random.default_rng(seed).random(len(out)) < 0.4
    out[rows] = out[rows][:, ::-1]
    return out


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("open_sides", [[], [0], [0, 1], [2, 3], [4, 5], [0, 2], [3, 4]])
@pytest.mark.parametrize("seed", [None, 0, 1])
def test_a_box_without_some_sides_has_the_volume_of_the_box(offset, open_sides, seed):
    kept = [t for side in range(6) if side not in open_sides for t in FULL[2 * side : 2 * side + 2]]
    triangles = np.array(kept) if seed is None else turned(np.array(kept), seed)
    points = CUBE * [2, 3, 4] + offset
    if open_sides in ([0, 2], [3, 4]):  # two neighbours: the edge of their opening is bent
        with pytest.raises(InputError, match="lies in no plane"):
            Volume(triangles)(points)
        return
    assert Volume(triangles)(points).values[0] == pytest.approx(24, rel=1e-9)


@pytest.mark.parametrize("offset", OFFSETS)
def test_derivatives_of_an_open_box_are_those_of_central_differences(offset):
    triangles = turned(FULL[2:])
    points, rng = CUBE + offset, np.random.default_rng(4)
    move = rng.normal(size=points.shape)
    move[:, 0] *= points[:, 0] - points[:, 0].min()  # the opening stays in its plane
    volume, h = Volume(triangles), 1e-4
    rows = np.asarray(volume(points).derivatives)
    difference = (volume(points + h * move).values - volume(points - h * move).values) / (2 * h)
    assert rows @ move.ravel() == pytest.approx(difference, rel=1e-5, abs=1e-6)


def test_points_that_lie_on_one_another_close_a_surface():
    """Each triangle with corners of its own, as an STL has it."""
    points = CUBE[FULL].reshape(-1, 3)
    triangles = np.arange(len(points)).reshape(-1, 3)
    assert Volume(triangles)(points).values[0] == pytest.approx(1)


def test_a_half_wing_measures_the_same_wherever_its_mesh_lies():
    mesh = read_mesh(sample("wing_air.su2"))
    name = next(name for name in mesh.markers if name.upper() == "WING")
    triangles = triangles_of(mesh.markers[name])
    values = [Volume(triangles)(mesh.points + [0, shift, 0]).values[0] for shift in (0, 10, -500)]
    assert values == pytest.approx([values[0]] * 3, rel=1e-9)
    loops = open_loops(oriented(triangles))
    assert len(loops) == 1
    assert np.ptp(mesh.points[loops[0], 1]) < 1e-9  # the symmetry plane


def test_an_edge_of_three_triangles_and_a_strip_of_one_side_are_refused():
    with pytest.raises(InputError, match="more than two triangles"):
        Volume(np.array([[0, 1, 2], [0, 1, 3], [1, 0, 4]]))(CUBE)
    n, angle = 30, np.linspace(0, 2 * np.pi, 30, endpoint=False)
    edges = [
        np.stack([(2 + s * np.cos(angle / 2)) * np.cos(angle),
                  (2 + s * np.cos(angle / 2)) * np.sin(angle), s * np.sin(angle / 2)], axis=1)
        for s in (-0.5, 0.5)
    ]  # fmt: skip
    moebius = []
    for k in range(n):
        a, b = (k, k + n) if k else (0, n)
        c, d = (k + 1, k + 1 + n) if k + 1 < n else (n, 0)
        moebius += [[a, c, b], [b, c, d]]
    with pytest.raises(InputError, match="one side only"):
        Volume(np.array(moebius))(np.concatenate(edges))


def test_several_bodies_add_up_and_each_is_closed_for_itself():
    points = np.concatenate([CUBE, CUBE * 2 + 5])
    triangles = np.concatenate([FULL[2:], FULL[4:] + 8])
    assert Volume(triangles)(points).values[0] == pytest.approx(9)
