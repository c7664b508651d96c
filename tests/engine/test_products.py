import numpy as np
import pytest

from ffdstudio.engine import Lattice
from ffdstudio.engine.deformation import Deformer
from ffdstudio.engine.drag import Drag
from ffdstudio.engine.embedding import Embedding
from ffdstudio.engine.inversion import Inversion
from ffdstudio.errors import InputError

SHAPES = {3: (8, 6, 4), 2: (5, 4), 1: (6,)}
DEGREES = {3: (3, 3, 3), 2: (3, 2), 1: (5,)}


def embedded(dimension, count, weighted=True, seed=0):
    """An embedding of points with parameters of their own, a tenth of them outside."""
    rng = np.random.default_rng(seed)
    box = Lattice.box([0, 0, 0], [1, 1, 1], SHAPES[dimension], DEGREES[dimension])
    weights = rng.uniform(0.5, 2, box.shape) if weighted else None
    current = box.moved(box.control_points + 0.2 * rng.random((*box.shape, 3)), weights)
    u = rng.random((count, dimension))
    u[: count // 20] = np.round(u[: count // 20])  # corners
    inside = rng.random(count) < 0.9
    found = Inversion(
        np.where(inside[:, None], u, np.nan), inside, np.zeros(count), np.zeros(count, np.uint16)
    )
    return Embedding(box, rng.random((count, 3)), found), current, rng


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_the_jacobians_are_the_central_differences(dimension):
    embedding, current, rng = embedded(dimension, 60)
    d_points, d_weights = rng.normal(size=(*current.shape, 3)), rng.normal(size=current.shape)
    h = 1e-6

    def difference(d_points, d_weights):
        ends = [
            embedding.deform(
                current.moved(
                    current.control_points + s * h * d_points, current.weights + s * h * d_weights
                )
            )
            for s in (1, -1)
        ]
        return (ends[0] - ends[1]) / (2 * h)

    by_points = embedding.jacobian(current) @ d_points.reshape(-1, 3)
    by_weights = embedding.weight_jacobian(current) @ d_weights.ravel()
    assert np.abs(by_points - difference(d_points, 0 * d_weights)).max() < 1e-8
    assert np.abs(by_weights - difference(0 * d_points, d_weights)).max() < 1e-8
    assert not by_points[~embedding.inside].any()
    assert not by_weights[~embedding.inside].any()


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("weighted", [False, True])
def test_products_are_those_with_the_matrices(dimension, weighted):
    embedding, current, rng = embedded(dimension, 400, weighted)
    d_points, d_weights = rng.normal(size=(*current.shape, 3)), rng.normal(size=current.shape)
    s = rng.normal(size=(400, 3))
    matrix, tensor = embedding.jacobian(current), embedding.weight_jacobian(current)
    pairs = [
        (embedding.jacobian_product(current, d_points), matrix @ d_points.reshape(-1, 3)),
        (embedding.weight_product(current, d_weights), tensor @ d_weights.ravel()),
        (embedding.jacobian_pullback(current, s).reshape(-1, 3), matrix.T @ s),
        (embedding.weight_pullback(current, s).ravel(), np.einsum("nkc,nk->c", tensor, s)),
    ]
    for ours, expected in pairs:
        assert np.abs(ours - expected).max() < 1e-12 * (1 + np.abs(expected).max())
    assert embedding.jacobian_pullback(current, s).shape == current.control_points.shape
    assert embedding.weight_pullback(current, s).shape == current.shape


def test_over_many_points_the_pullback_is_the_transpose_and_repeats_its_bits():
    embedding, current, rng = embedded(3, 60_000)
    d_points, d_weights = rng.normal(size=(*current.shape, 3)), rng.normal(size=current.shape)
    s = rng.normal(size=(60_000, 3))
    back = embedding.jacobian_pullback(current, s)
    forth = embedding.jacobian_product(current, d_points)
    assert np.vdot(back, d_points) == pytest.approx(np.vdot(s, forth), abs=1e-9)
    turned = embedding.weight_product(current, d_weights)
    gradient = embedding.weight_pullback(current, s)
    assert np.vdot(gradient, d_weights) == pytest.approx(np.vdot(s, turned), abs=1e-9)
    assert np.array_equal(back, embedding.jacobian_pullback(current, s))


def test_wrong_shapes_are_refused():
    embedding, current, _ = embedded(2, 10)
    with pytest.raises(InputError, match="motion of the control points"):
        embedding.jacobian_product(current, np.zeros((3, 3)))
    with pytest.raises(InputError, match="change of the weights"):
        embedding.weight_product(current, np.zeros(3))
    with pytest.raises(InputError, match="sensitivities"):
        embedding.jacobian_pullback(current, np.zeros((9, 3)))
    finer = current.insert_knots(0, [0.3])
    for refused in (embedding.jacobian, embedding.weight_jacobian):
        with pytest.raises(InputError, match="other degrees or knots"):
            refused(finer)


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("count", [500, 60_000])
def test_a_drag_is_the_deformation_of_the_moved_lattice(weighted, count):
    embedding, current, _ = embedded(3, count, weighted)
    chosen, vector = [70, 71, 100], np.array([0.1, 0.0, -0.2])
    drag = embedding.drag(current, chosen)
    start = embedding.deform(current)
    net = current.control_points.copy()
    net.reshape(-1, 3)[chosen] += vector
    expected = embedding.deform(current.moved(net))
    moved = drag.move(vector, start.copy())
    assert np.abs(moved - expected).max() < 1e-14
    followers = np.zeros(count, bool)
    followers[drag.rows] = True
    share = np.asarray(embedding.jacobian(current)[:, chosen].sum(axis=1)).ravel()
    assert (followers == (share > 0)).all()
    assert np.abs(drag.influence - share[drag.rows]).max() < 1e-15
    assert np.array_equal(moved[~followers], start[~followers])
    # the twin
    twin = drag.start + drag.influence[:, None] * vector
    assert np.array_equal(moved[drag.rows], twin)


def test_a_drag_back_to_where_it_began_restores_the_bits():
    embedding, _, _ = embedded(3, 300)
    points = np.full((300, 3), -0.0)
    deformer = Deformer(embedding.lattice, points, embedding.parameters, embedding.inside)
    drag = Drag(deformer, embedding.lattice, np.arange(192))
    out = drag.move([1, 2, 3], points.copy())
    drag.move([0, 0, 0], out)
    assert np.signbit(out).all()
    assert not out.any()


def test_a_wrong_drag_is_refused():
    embedding, current, _ = embedded(2, 10)
    for wrong in ([20], [-1], [0.5]):
        with pytest.raises(InputError, match="control points"):
            embedding.drag(current, wrong)
    drag = embedding.drag(current, [])
    assert len(drag.rows) == 0
    with pytest.raises(InputError, match="3 finite numbers"):
        drag.move([1, np.nan, 0], np.zeros((10, 3)))
    with pytest.raises(InputError, match="output"):
        drag.move([1, 0, 0], np.zeros((9, 3)))
