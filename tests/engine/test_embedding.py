import threading

import numpy as np
import pytest

from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.inversion import METHODS
from ffdstudio.errors import InputError
from tests.engine.nets import CURVED, quarter_cylinder, random_lattice

FAST = ("newton", "secant")


def points_inside(lattice, n, seed=0):
    rng = np.random.default_rng(seed)
    u = rng.uniform(*lattice.domain.T, (n, lattice.dimension))
    return lattice.evaluate(u), u


def points_beside(lattice, n, distance, seed=0):
    """Points that lie outside one face by `distance` diagonals, along its normal."""
    rng = np.random.default_rng(seed)
    u = rng.uniform(size=(n, 3))
    axis, side = rng.integers(0, 3, n), rng.integers(0, 2, n)
    rows = np.arange(n)
    u[rows, axis] = side
    steps = np.eye(3, dtype=int)
    jacobian = np.stack([lattice.evaluate(u, steps[k]) for k in range(3)], axis=-1)
    normal = np.linalg.inv(jacobian)[rows, axis] * np.where(side, 1, -1)[:, None]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return lattice.evaluate(u) + distance * lattice.diagonal * normal


@pytest.mark.parametrize("name", CURVED)
@pytest.mark.parametrize("method", FAST)
def test_no_point_inside_a_curved_net_is_lost(name, method):
    lattice = CURVED[name]()
    x, u = points_inside(lattice, 300_000)
    found = embed(lattice, x, method)
    assert found.inside.all()
    assert found.residual.max() <= 1e-12 * lattice.diagonal
    back = lattice.evaluate(found.parameters)
    assert np.abs(back - x).max() <= 1.1e-12 * lattice.diagonal
    assert np.abs(found.parameters - u).max() <= 1e-10


@pytest.mark.parametrize("name", CURVED)
@pytest.mark.parametrize("method", ["octree", "golden"])
def test_the_slow_methods_find_the_same(name, method):
    lattice = CURVED[name]()
    x, u = points_inside(lattice, 500)
    found = embed(lattice, x, method)
    assert found.inside.all()
    assert np.abs(found.parameters - u).max() <= 1e-10


@pytest.mark.parametrize("name", CURVED)
@pytest.mark.parametrize("method", FAST)
@pytest.mark.parametrize("distance", [1e-6, 1e-4, 1e-2])
def test_no_point_beside_a_face_is_taken_for_inside(name, method, distance):
    lattice = CURVED[name]()
    found = embed(lattice, points_beside(lattice, 10_000, distance), method)
    assert not found.inside.any()
    assert np.isnan(found.parameters).all()
    assert np.isinf(found.residual).all()


@pytest.mark.parametrize("method", METHODS)
def test_the_hole_of_a_ring_is_outside(method):
    lattice = CURVED["annulus"]()
    rng = np.random.default_rng(1)
    inner = lattice.evaluate(np.stack([np.linspace(0, 1, 500), *np.zeros((2, 500))], axis=1))
    clear = 0.99 * np.hypot(inner[:, 0], inner[:, 1]).min()
    angle, radius = rng.uniform(0, 2 * np.pi, 3000), clear * np.sqrt(rng.uniform(size=3000))
    hole = np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0, 0.4, 3000)], axis=1
    )
    assert not embed(lattice, hole, method).inside.any()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", [*CURVED, "box", "uniform"])
def test_faces_edges_and_corners_are_inside(name, method):
    if name in CURVED:
        lattice = CURVED[name]()
    else:
        spacing = "greville" if name == "box" else "uniform"
        lattice = Lattice.box([0.1, 0.2, 0.3], [0.7, 1.9, 3.3], (6, 5, 4), spacing=spacing)
    ends = np.linspace(*lattice.domain.T, 3)
    grid = np.stack(np.meshgrid(*ends.T, indexing="ij"), axis=-1).reshape(-1, 3)
    assert embed(lattice, lattice.evaluate(grid), method).inside.all()


@pytest.mark.parametrize("name", ["wing", "box"])
def test_a_point_within_a_billionth_of_a_face_counts_as_on_it(name):
    lattice = CURVED[name]() if name in CURVED else Lattice.box([0, 0, 0], [1, 1, 1], (5, 4, 4))
    near = embed(lattice, points_beside(lattice, 1000, 0.9e-9))
    assert near.inside.all()
    assert near.residual.max() <= 1e-9 * lattice.diagonal
    low, high = lattice.domain.T
    assert ((near.parameters >= low) & (near.parameters <= high)).all()
    assert not embed(lattice, points_beside(lattice, 1000, 1.1e-8)).inside.any()


@pytest.mark.parametrize("method", METHODS)
def test_weighted_nets_are_inverted(method):
    lattice = quarter_cylinder()
    x, u = points_inside(lattice, 300)
    found = embed(lattice, x, method)
    assert found.inside.all()
    assert np.abs(found.parameters - u).max() <= 1e-10


def test_random_weighted_nets_lose_no_point():
    for seed in range(5):
        lattice = random_lattice(np.random.default_rng(seed), spread=0.02)
        x, _ = points_inside(lattice, 2000, seed)
        found = embed(lattice, x)
        assert found.inside.all()
        assert np.abs(lattice.evaluate(found.parameters) - x).max() <= 2e-12 * lattice.diagonal


def test_a_box_at_rest_is_solved_in_closed_form_to_the_bit():
    box = Lattice.box([-1, 0, 2], [3, 1, 5], (8, 6, 4))
    x, u = points_inside(box, 1000)
    found = embed(box, u)
    np.testing.assert_array_equal(found.parameters, u)
    assert (found.iterations == 0).all()
    assert np.abs(x - u).max() < 1e-14
    refined = box.insert_knots(0, [0.3]).elevate_degree(1)
    assert (embed(refined, u).iterations == 0).all()


def test_a_sheared_box_is_solved_in_closed_form():
    box = Lattice.box([0, 0, 0], [1, 1, 1], (5, 4, 3))
    shear = np.array([[1, 0.2, 0], [0.1, 2, 0.3], [0, 0.1, 0.5]])
    lattice = box.moved(box.control_points @ shear + [5, 6, 7])
    x, u = points_inside(lattice, 1000)
    found = embed(lattice, x)
    assert (found.iterations == 0).all()
    np.testing.assert_allclose(found.parameters, u, atol=1e-14)
    assert found.residual.max() < 1e-14 * lattice.diagonal * 5


@pytest.mark.parametrize("method", METHODS)
def test_flat_lattices_ignore_the_other_coordinates(method):
    box = Lattice.box([0, 0, 0], [1, 2, 0], (6, 4))
    p = box.control_points.copy()
    p[..., 0] += 0.05 * np.sin(3 * p[..., 1])
    p[..., 1] += 0.1 * p[..., 0]
    lattice = box.moved(p)
    x, u = points_inside(lattice, 300)
    x[:, 2] = np.linspace(-5, 5, 300)
    found = embed(lattice, x, method)
    assert found.inside.all()
    assert np.abs(found.parameters - u).max() <= 1e-10
    raised = found.deform(lattice.moved(p + [0, 0, 1]))
    np.testing.assert_allclose(raised, x + [0, 0, 1], atol=1e-14)


def test_a_line_bends_space_along_its_axis():
    line = Lattice.box([0, 0, 0], [4, 0, 0], (5,), axes=[[0, 1, 0]])
    np.testing.assert_allclose(line.control_points[-1], [0, 4, 0])
    up = line.control_points.copy()
    up[:, 2] = up[:, 1] ** 2
    x = np.random.default_rng(0).uniform(0, 4, (100, 3))
    moved = embed(line, x).deform(line.moved(up)) - x
    np.testing.assert_allclose(moved[:, :2], 0, atol=1e-15)
    np.testing.assert_allclose(moved[:, 2], line.moved(up).evaluate(x[:, 1:2])[:, 2], atol=1e-14)


def test_geometry_far_from_the_origin_loses_no_digits_of_the_parameters():
    lattice = CURVED["wavy"]()
    far = lattice.moved(lattice.control_points + 1e6)
    x, u = points_inside(lattice, 1000)
    found = embed(far, x + 1e6)
    assert found.inside.all()
    assert np.abs(found.parameters - u).max() < 1e-8  # the coordinates themselves carry 1e-10


@pytest.mark.parametrize("refine", ["insert", "elevate"])
def test_refinement_carries_the_embedding_along(refine):
    rest = CURVED["wing"]()
    rng = np.random.default_rng(2)
    current = rest.moved(
        rest.control_points + rng.normal(scale=0.02, size=rest.control_points.shape),
        rng.uniform(0.8, 1.25, rest.shape),
    )
    x, _ = points_inside(rest, 2000)
    found = embed(rest, x)

    def finer(lattice):
        if refine == "insert":
            return lattice.insert_knots(0, [0.33, 0.5]).insert_knots(2, [0.7])
        return lattice.elevate_degree(1)

    after = found.refined(finer(rest)).deform(finer(current))
    assert np.abs(after - found.deform(current)).max() <= 1e-13 * rest.diagonal
    still = found.refined(finer(rest)).deform(finer(rest))
    np.testing.assert_array_equal(still, x)


def test_coarsening_carries_the_embedding_along():
    box = Lattice.box([0, 0, 0], [1, 1, 1], (8, 4, 4))
    finer = box.insert_knots(0, [0.33])
    x, _ = points_inside(box, 500)
    moved = finer.moved(finer.control_points + np.sin(finer.control_points))
    embedding = embed(finer, x)
    coarse = moved.remove_knots(0, [0.33], tolerance=0.1)
    carried = embedding.refined(finer.remove_knots(0, [0.33])).deform(coarse)
    assert np.abs(carried - embedding.deform(moved)).max() <= 0.1


def test_a_point_is_treated_alike_wherever_it_stands():
    lattice = CURVED["annulus"]()
    x, _ = points_inside(lattice, 20_000)
    order = np.random.default_rng(3).permutation(len(x))
    whole, shuffled = embed(lattice, x), embed(lattice, x[order])
    np.testing.assert_array_equal(whole.parameters[order], shuffled.parameters)
    np.testing.assert_array_equal(embed(lattice, x[:7]).parameters, whole.parameters[:7])


def test_several_threads_may_embed_at_once():
    lattice = CURVED["wavy"]()
    x, u = points_inside(lattice, 20_000)
    errors = []

    def work():
        errors.append(np.abs(embed(lattice, x).parameters - u).max())

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(errors) == 4
    assert max(errors) <= 1e-10


def test_a_folded_net_is_survived():
    box = Lattice.box([0, 0, 0], [1, 1, 1], (5, 4, 4))
    p = box.control_points.copy()
    p[2, :, :, 0] -= 0.6  # folds back over itself
    lattice = box.moved(p)
    x, _ = points_inside(lattice, 2000)
    found = embed(lattice, x)
    assert found.inside.mean() > 0.99
    back = lattice.evaluate(found.parameters[found.inside])
    assert np.abs(back - x[found.inside]).max() <= 1e-9


def test_a_collapsed_edge_is_survived():
    box = Lattice.box([0, 0, 0], [1, 1, 1], (4, 4, 4))
    p = box.control_points.copy()
    p[..., 0] *= p[..., 1]  # a wedge: the edge y = 0 collapses
    lattice = box.moved(p)
    x, _ = points_inside(lattice, 2000)
    assert embed(lattice, x).inside.all()


def test_no_points_at_all_are_fine():
    for lattice in (Lattice.box([0, 0, 0], [1, 1, 1]), CURVED["wing"]()):
        empty = embed(lattice, np.empty((0, 3)))
        assert empty.deform(lattice).shape == (0, 3)
        nowhere = embed(lattice, [[9.0, 9, 9]])
        np.testing.assert_array_equal(nowhere.deform(lattice.moved(lattice.control_points + 1)), 9)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda x: embed(x, [[0, 0]]), "must be an array"),
        (lambda x: embed(x, [[0, 0, 0], [0, np.nan, 0]]), "point 1"),
        (lambda x: embed(x, [[0, 0, 0]], "bisection"), "method must be one of newton, secant"),
        (lambda x: embed(x, [[0, 0, 0]], tolerance=0), "tolerance"),
        (lambda x: embed(x, [[0, 0, 0]]).deform(x.elevate_degree(0)), "other degrees or knots"),
        (lambda x: embed(x, [[0, 0, 0]]).refined(Lattice.box([0, 0, 0], [1, 1, 2])), "range"),
    ],
)
def test_wrong_input_is_refused_in_words(call, words):
    with pytest.raises(InputError, match=words):
        call(Lattice.box([0, 0, 0], [1, 1, 1]))


def polar_net():
    """A fuselage: j = 0 is its axis, where the map is singular."""
    lattice = Lattice.box([0, 0, 0], [1, 1, 1], shape=(7, 4, 4))
    q = lattice.control_points
    angle, radius = 2 * np.pi * q[..., 0], q[..., 1] * (1.1 - q[..., 2])
    around = [4 * q[..., 2], radius * np.cos(angle), radius * np.sin(angle)]
    return lattice.moved(np.stack(around, axis=-1))


@pytest.mark.parametrize("method", FAST)
def test_no_point_near_the_axis_of_a_polar_net_is_lost(method):
    lattice, rng = polar_net(), np.random.default_rng(0)
    off = 10.0 ** rng.uniform(-7, -1, 1000)
    x = lattice.evaluate(np.column_stack([rng.random(1000), off, rng.random(1000)]))
    found = embed(lattice, x, method)
    assert found.inside.all()
    assert np.abs(lattice.evaluate(found.parameters) - x).max() <= 2e-9 * lattice.diagonal
    beyond = rng.uniform(-2, 5, (2000, 3))
    beyond = beyond[np.hypot(beyond[:, 1], beyond[:, 2]) > 1.2]
    assert not embed(lattice, beyond, method).inside.any()


@pytest.mark.parametrize("offset", [1e3, 1e6, 1e7])
@pytest.mark.parametrize("kind", ["greville", "uniform", "weighted", "plane"])
def test_a_lattice_far_from_the_origin_loses_no_point(kind, offset):
    rng = np.random.default_rng(1)
    shape = (6, 5) if kind == "plane" else (6, 5, 4)
    spacing = "uniform" if kind in ("uniform", "plane") else "greville"
    box = Lattice.box([offset] * 3, [offset + 1] * 3, shape, spacing=spacing)
    if kind == "weighted":
        box = box.moved(weights=rng.uniform(0.5, 2, shape))
    ends = np.linspace(*box.domain.T, 3)
    faces = np.stack(np.meshgrid(*ends.T, indexing="ij"), -1).reshape(-1, len(shape))
    for u in (rng.uniform(*box.domain.T, (500, len(shape))), faces):
        found = embed(box, box.evaluate(u))
        assert found.inside.all()
        low, high = box.domain.T
        assert ((found.parameters >= low) & (found.parameters <= high)).all()
    away = 2e-8 + 1e-14 * offset
    assert not embed(box, [[offset - away, offset + 0.5, offset + 0.5]]).inside.any()


def test_a_flat_net_is_refused_in_words():
    flat = Lattice.box([0, 0, 0], [1, 1, 1], (4, 4, 4))
    for net in (flat.control_points * [1, 1, 0], 0 * flat.control_points):
        with pytest.raises(InputError, match="the lattice is flat"):
            embed(flat.moved(net), [[0.5, 0.5, 0.0]])
    curved = flat.control_points**2 * [1, 1, 0]
    with pytest.raises(InputError, match="the lattice is flat"):
        embed(flat.moved(curved), [[0.5, 0.5, 0.0]])


def test_a_lattice_is_cut_into_cells_once_and_let_go_with_it():
    lattice = CURVED["wavy"]()
    embed(lattice, [[0.5, 0.5, 0.5]])
    first = lattice.memo["prepared"]
    embed(lattice, [[0.4, 0.5, 0.5]])
    assert lattice.memo["prepared"] is first
    assert not lattice.moved().memo


@pytest.mark.parametrize("points", ["abc", [[0, 0], [1]], None])
def test_points_that_are_no_numbers_are_refused(points):
    with pytest.raises(InputError, match="points to embed must be an array"):
        embed(Lattice.box([0, 0, 0], [1, 1, 1], (2, 2, 2)), points)


@pytest.mark.parametrize("tolerance", [0, -1, np.nan, np.inf, "1", None])
def test_a_wrong_tolerance_is_refused(tolerance):
    with pytest.raises(InputError, match="tolerance"):
        embed(Lattice.box([0, 0, 0], [1, 1, 1], (2, 2, 2)), [[0, 0, 0]], tolerance=tolerance)
