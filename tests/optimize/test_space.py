import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ffdstudio as ffd
from ffdstudio.engine.transfer import insertion
from ffdstudio.errors import InputError
from ffdstudio.optimize.variables.rules import Rules
from ffdstudio.optimize.variables.space import DesignSpace, Insertion, new_function

BOX = ffd.Lattice.box([0, 0, 0], [2, 1, 1], shape=(5, 4, 3), degrees=(3, 2, 1))
ALL = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
RULES = [
    Rules(),
    Rules(directions=ALL, frozen=(1, 0, 0)),
    Rules(directions=ALL, linked=(2,)),
    Rules(directions=ALL, mirror=(1, (0.0, 1.0, 0.0))),
    Rules(directions=ALL, fixed=((2, 1, 1), (0, 0, 0))),
]


def points() -> np.ndarray:
    return np.random.default_rng(0).uniform([0, 0, 0], [2, 1, 1], size=(60, 3))


@pytest.mark.parametrize("rules", RULES)
@pytest.mark.parametrize("weighted", [False, True])
def test_a_refined_space_holds_every_shape_of_the_old_one(rules, weighted):
    rng = np.random.default_rng(1)
    weights = rng.uniform(0.5, 2, BOX.shape) if weighted else None
    rest = BOX.moved(weights=weights)
    space = DesignSpace.of(rest, rules)
    for new in (Insertion(0, 0.7), Insertion(0, 1.3)):
        finer, carry = space.refined(new)
        y = rng.normal(size=space.size)
        coarse, fine = space.at(y), finer.at(carry @ y)
        before = ffd.embed(rest, points()).deform(coarse) if space.rest is rest else None
        uvw = rng.uniform([0, 0, 0], [2, 1, 1], size=(40, 3))
        np.testing.assert_allclose(coarse.evaluate(uvw), fine.evaluate(uvw), atol=1e-12)
        assert before is None or np.isfinite(before).all()
        assert finer.size > space.size
        space = finer


def test_frozen_layers_stay_frozen_after_refinement():
    space = DesignSpace.of(BOX, Rules(directions=ALL, frozen=(1, 0, 0)))
    finer, _ = space.refined(Insertion(0, 0.1))
    moved = finer.at(np.ones(finer.size)).control_points - finer.lattice.control_points
    assert (moved[[0, -1]] == 0).all()
    assert (moved[1:-1] != 0).any(axis=-1).all()


def test_mirrored_control_points_move_as_images():
    space = DesignSpace.of(BOX, Rules(directions=ALL, mirror=(1, (0.0, 1.0, 0.0))))
    step = space.at(np.random.default_rng(2).normal(size=space.size)).control_points
    step = step - BOX.control_points
    np.testing.assert_allclose(step[:, ::-1] * [1, -1, 1], step, atol=1e-15)


def test_linked_control_points_move_as_one():
    space = DesignSpace.of(BOX, Rules(linked=(2,)))
    step = space.at(np.arange(space.size, dtype=float)).control_points - BOX.control_points
    assert (step[:, :, :1] == step).all()
    with pytest.raises(InputError, match="linked"):
        space.refined(Insertion(2, 0.5))


def test_a_row_gets_a_column_of_its_own():
    lattice = ffd.Lattice.box([0, 0, 0], [1, 1, 0], shape=(4, 3), degrees=(3, 2))
    space = DesignSpace.of(lattice, Rules())
    finer, carry = space.refined(Insertion(0, 0.3, line=1))
    assert finer.size == space.size + 1
    assert finer.rest.shape == (5, 3)
    again, _ = finer.refined(Insertion(0, 0.3, line=2))
    assert (again.size, again.rest.shape) == (space.size + 2, (5, 3))
    y = np.random.default_rng(4).normal(size=space.size)
    uv = np.random.default_rng(4).random((30, 2))
    np.testing.assert_allclose(
        space.at(y).evaluate(uv), finer.at(carry @ y).evaluate(uv), atol=1e-13
    )


@settings(max_examples=60, deadline=None)
@given(
    st.integers(1, 5),
    st.lists(st.floats(0.05, 0.95), max_size=5, unique=True),
    st.floats(0.01, 0.99),
)
def test_the_new_function_is_the_one_that_the_null_vector_of_the_insertion_names(
    degree, inner, knot
):
    ends = [0.0] * (degree + 1), [1.0] * (degree + 1)
    knots = np.array([*ends[0], *sorted(inner), *ends[1]])
    normal = np.abs(np.linalg.svd(insertion(knots, degree, [knot])[1])[0][:, -1])
    assert normal[new_function(knots, degree, knot, 0)] >= normal.max() * (1 - 1e-6)


def test_rules_that_leave_nothing_are_refused():
    with pytest.raises(InputError, match="leave nothing"):
        DesignSpace.of(BOX, Rules(frozen=2))
    with pytest.raises(InputError, match="no control point"):
        DesignSpace.of(BOX, Rules(fixed=((9, 0, 0),)))


def test_a_ring_is_moved_by_studies_and_refined_in_its_other_directions_alone():
    ring = ffd.Lattice.cylinder((1, 2), shape=(4, 8))
    space = DesignSpace.of(ring, Rules(directions=ALL[:2]))
    assert space.size == 2 * ring.weights.size
    with pytest.raises(InputError, match="direction j is periodic: studies do not refine it"):
        space.refined(Insertion(1, 0.3))
    finer, carry = space.refined(Insertion(0, 1.5))
    y = 0.01 * np.random.default_rng(0).normal(size=space.size)
    uvw = np.random.default_rng(1).uniform(*ring.domain.T, (40, 2))
    np.testing.assert_allclose(
        space.at(y).evaluate(uvw), finer.at(carry @ y).evaluate(uvw), atol=1e-13
    )
