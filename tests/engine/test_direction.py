"""Directions, clamped and periodic, against SciPy's splines."""

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_interp_spline

from ffdstudio.engine import Lattice
from ffdstudio.engine.direction import Direction
from ffdstudio.errors import InputError


def ring(degree, multiplicity=1, low=-0.5, seed=0):
    """A periodic direction over [low, low + 1.5] with uneven knots."""
    rng = np.random.default_rng(seed)
    turn = np.append(low + 1.5 * np.sort(rng.uniform(0.05, 0.95, degree + 4)), low + 1.5)
    turn = np.repeat(turn, multiplicity)
    before = np.where(turn == turn[-1], low, turn - 1.5)[len(turn) - degree - 1 :]
    knots = np.concatenate([before, turn, turn[:degree] + 1.5])
    return Direction.checked(knots, degree, len(turn), periodic=True)


def scipy_spline(direction, control):
    around = np.concatenate([control, control[: direction.degree]])
    return BSpline(direction.knots, around, direction.degree)


CASES = [(p, m) for p in (1, 2, 3, 4, 5) for m in (1, 2) if m <= p]


@pytest.mark.parametrize(("degree", "multiplicity"), CASES)
def test_functions_and_refinement_are_those_of_scipys_periodic_splines(degree, multiplicity):
    rng = np.random.default_rng(degree)
    line = ring(degree, multiplicity)
    control = rng.normal(size=line.count)
    u = np.append(rng.uniform(*line.domain, 300), line.breaks[:-1])
    expected = scipy_spline(line, control)
    for order in range(min(3, degree - multiplicity + 1) + 1):
        values = expected(u) if order == 0 else expected.derivative(order)(u)
        ours = line.matrix(u, order) @ control
        assert np.abs(ours - values).max() < 1e-13 * (1 + np.abs(values).max())
    room = degree > multiplicity
    new = np.array([0.1, 0.31] + [line.domain[0]] * room)
    finer, matrix = line.inserted(new)
    assert finer.count == line.count + len(new)
    assert np.abs(scipy_spline(finer, matrix @ control)(u) - expected(u)).max() < 1e-13
    higher, matrix = line.elevated()
    assert np.abs(scipy_spline(higher, matrix @ control)(u) - expected(u)).max() < 1e-13
    open_one, matrix = line.clamped()
    assert np.abs(BSpline(open_one.knots, matrix @ control, degree)(u) - expected(u)).max() < 1e-13


def test_it_is_the_space_that_scipy_interpolates_periodically_in():
    places = np.linspace(0, 1, 11)
    values = np.append(np.random.default_rng(0).normal(size=10), 0.0)
    values[-1] = values[0]
    theirs = make_interp_spline(places, values, k=3, bc_type="periodic")
    line = Direction.uniform(10, 3, 0.0, 1.0, periodic=True)
    assert np.abs(line.knots - theirs.t).max() < 1e-15
    u = np.random.default_rng(1).random(200)
    assert np.abs(line.matrix(u) @ theirs.c[:10] - theirs(u)).max() < 1e-13


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_what_was_inserted_is_removed_again_also_at_the_seam(degree):
    line = ring(degree)
    new = np.array([0.2, 0.3] + [line.domain[0]] * (degree > 1))
    finer, there = line.inserted(new)
    coarser, back, _ = finer.removed(new)
    assert np.abs(coarser.knots - line.knots).max() < 1e-15
    assert np.abs(back @ there - np.eye(line.count)).max() < 1e-12


@pytest.mark.parametrize("degree", [2, 3, 5])
def test_the_seam_is_a_knot_like_any_other(degree):
    """Starting the turn elsewhere changes the names of the control points and nothing else."""
    line = Direction.uniform(9, degree, 0.0, 9.0, periodic=True)
    u = np.linspace(0, 9, 91)[:-1]
    one = line.matrix(u)
    assert np.abs(np.roll(np.roll(one, 10, axis=0), 1, axis=1) - one).max() < 1e-14
    below, above = line.matrix([9.0 - 1e-9]), line.matrix([1e-9])
    assert np.abs(below - above).max() < 1e-8


@pytest.mark.parametrize(
    ("knots", "count", "words"),
    [
        ([0, 1, 2, 3, 4], 3, "need 8 knots"),
        ([-2, -1, 0, 1, 2, 3, 4, 6], 3, "repeat after 3"),
        ([-2, -1, 0, 0, 2, 3, 4, 5], 3, "repeat|begin at the last"),
        ([-3, 0, 0, 0, 3, 3, 3, 6], 3, "begin at the last|at most 2"),
        ([-2, -1, 0, 1, 0.5, 3, 4, 5], 3, "not decrease"),
        ([-2, -1, 0, 1, np.nan, 3, 4, 5], 3, "finite"),
        ([-1, 0, 1, 2, 3, 4, 5], 2, "at least 3"),
    ],
)
def test_knots_that_do_not_go_around_are_refused(knots, count, words):
    with pytest.raises(InputError, match=words):
        Direction.checked(knots, 2, count, "j", periodic=True)


def test_knots_of_a_periodic_lattice_are_changed_as_asked_or_refused():
    rng = np.random.default_rng(3)
    lattice = Lattice.cylinder((1, 2), shape=(3, 8))
    lattice = lattice.moved(
        lattice.control_points + 0.1 * rng.normal(size=lattice.control_points.shape),
        rng.uniform(0.5, 2, lattice.shape),
    )
    u = rng.uniform(*lattice.domain.T, (500, 2))
    finer = lattice.insert_knots(1, [0.0, 0.3, 0.3]).elevate_degree(1).elevate_degree(0)
    assert np.abs(finer.evaluate(u) - lattice.evaluate(u)).max() < 1e-14 * lattice.diagonal
    assert finer.periodic == (False, True)
    again = lattice.insert_knots(1, [0.0, 0.3]).remove_knots(1, [0.0, 0.3])
    assert np.abs(again.control_points - lattice.control_points).max() < 1e-12
    seam = lattice.domain[1, 1]
    for call, words in [
        (lambda: lattice.insert_knots(1, [seam]), r"inside \[0, "),
        (lambda: lattice.insert_knots(1, [0.0] * 3), "more than 3 times"),
        (lambda: lattice.remove_knots(1, [0.123]), "no inner knot"),
        (lambda: lattice.remove_knots(1, lattice.knots[1][4:9]), "periodic and needs more"),
        (lambda: lattice.remove_knots(1, [lattice.knots[1][4]]), "would move"),
    ]:
        with pytest.raises(InputError, match=words):
            call()
