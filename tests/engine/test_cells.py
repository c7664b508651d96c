"""Cells of the inversion: what is known of them is right, and few are made at first."""

import numpy as np
import pytest

from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.inversion import cells, descent
from ffdstudio.engine.inversion.net import Net
from tests.engine.nets import CURVED, quarter_cylinder, random_lattice
from tests.engine.test_embedding import polar_net

CUBIC = Lattice.box([0, 0, 0], [1, 1, 1], shape=(6, 4, 4))


def hard_nets():
    """Nets at rest whose maps are far from affine, and which points of the box they hold."""
    rng = np.random.default_rng(0)
    pulled = CUBIC.control_points.copy()
    pulled[2, 2, 2] += 3
    spike = np.ones(CUBIC.shape)
    spike[2, 2, 2] = 1000
    return {
        "weights": CUBIC.moved(weights=10 ** rng.uniform(-1.5, 1.5, CUBIC.shape)),
        "one weight": CUBIC.moved(weights=spike),
        "pulled": CUBIC.moved(pulled),
        "plane": Lattice.box([0, 0], [1, 1], (4, 6), (1, 2)).moved(
            weights=10 ** rng.uniform(-2, 2, (4, 6))
        ),
    }


@pytest.mark.parametrize("name", ["weights", "one weight", "plane"])
def test_a_weighted_box_holds_the_points_of_the_box_and_no_others(name):
    lattice = hard_nets()[name]
    x = np.random.default_rng(1).uniform(-0.2, 1.2, (4000, 3))
    found = embed(lattice, x)
    within = ((x >= 0) & (x <= 1))[:, : lattice.dimension].all(axis=1)
    assert (found.inside == within).all()
    back = lattice.evaluate(found.parameters[within])[:, : lattice.dimension]
    assert np.abs(back - x[within, : lattice.dimension]).max() <= 1.1e-12 * lattice.diagonal


@pytest.mark.parametrize("name", hard_nets())
def test_few_cells_are_made_at_first_whatever_the_net(name):
    net = Net.of(hard_nets()[name]).padded()
    made, bent, _ = cells.cut(net)
    spans = np.prod([len(np.unique(u)) - 1 for u in net.knots])
    assert len(made.bend) <= spans + cells.AT_FIRST
    assert sum(part.nbytes for part in (*made, *bent)) < 2 * cells.ROOM
    assert np.prod(2 * made.half, axis=1).sum() == pytest.approx(1 * net.knots[2][-1])


@pytest.mark.parametrize("name", hard_nets())
def test_what_a_point_gets_does_not_depend_on_the_halves_made_for_others(name):
    lattice = hard_nets()[name]
    x = np.random.default_rng(2).uniform(-0.1, 1.1, (3000, 3))
    order = np.random.default_rng(3).permutation(len(x))
    whole, shuffled = embed(lattice, x), embed(lattice, x[order])
    np.testing.assert_array_equal(whole.parameters[order], shuffled.parameters)
    np.testing.assert_array_equal(whole.residual[order], shuffled.residual)
    alone = [embed(lattice, x[[i]]).parameters[0] for i in range(0, 3000, 301)]
    np.testing.assert_array_equal(whole.parameters[::301], alone)


def test_halves_that_no_longer_fit_are_thrown_away_and_made_again():
    lattice = hard_nets()["pulled"]
    x = np.random.default_rng(4).uniform(-0.1, 1.5, (3000, 3))
    _, bent, _ = cells.cut(Net.of(lattice).padded())
    tree = descent.new_tree(bent)
    assert len(tree.pool.bend) < len(bent.control) + 2 * descent.BUDGET + 4000  # they run out
    found = embed(lattice, x)
    back = lattice.evaluate(found.parameters[found.inside])
    assert np.abs(back - x[found.inside]).max() <= 1.1e-12 * lattice.diagonal


@pytest.mark.parametrize(
    "make", [*CURVED.values(), quarter_cylinder, polar_net, lambda: hard_nets()["weights"]]
)
def test_a_cell_lies_in_its_bounds_and_bends_no_more_than_it_says(make):
    lattice = make()
    made, _, _ = cells.cut(Net.of(lattice))
    rng = np.random.default_rng(5)
    flat = lattice.control_points.reshape(-1, 3)
    for c in rng.choice(len(made.bend), 20):
        s = rng.uniform(-1, 1, (60, 3))
        u = np.clip(made.middle[c] + made.half[c] * s, *lattice.domain.T)
        x = lattice.evaluate(u)
        tiny = 1e-12 * np.abs(flat).max()
        assert (x >= made.lower[c] - tiny).all()
        assert (x <= made.upper[c] + tiny).all()
        y = (x - made.centre[c]) @ made.inverse[c].T
        assert (y >= made.low[c] - 1e-6).all()
        assert (y <= made.high[c] + 1e-6).all()
        rows = [lattice.evaluate(u, np.eye(3, dtype=int)[k]) * made.half[c, k] for k in range(3)]
        slopes = np.einsum("re,nde->nrd", made.inverse[c], np.stack(rows, axis=1))
        bend = np.abs(slopes - np.eye(3)).sum(axis=2).max()
        assert bend <= 1.3 * made.bend[c] + 1e-9


def test_straight_cells_are_never_halved_again():
    made, bent, _ = cells.cut(Net.of(random_lattice(np.random.default_rng(0), spread=0.01)))
    assert ((bent.place >= 0) == (made.bend > cells.BEND)).all()
