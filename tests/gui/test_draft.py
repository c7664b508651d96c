"""A lattice that is being built: what is wrong with it, and its frame."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ffdstudio.gui.panels.draft import Draft, angles_of, frame, inside_box, principal_frame

GOOD = Draft("Box", (4, 3, 3), (3, 2, 2), (0, 0, 0), (1, 2, 3))


def changed(**fields):
    from dataclasses import replace

    return replace(GOOD, **fields)


@pytest.mark.parametrize(
    ("draft", "field", "word"),
    [
        (changed(degrees=(4, 2, 2)), "direction 0", "5 points"),
        (changed(lower=(0, 2, 0)), "bounds 1", "above"),
        (changed(upper=(1, 2, None)), "bounds 2", "two numbers"),
        (changed(frozen=2), "frozen", "no free point"),
        (changed(name="  "), "name", "name"),
        (changed(counts=(999, 999, 3)), "direction 0", "too many"),
    ],
)
def test_what_is_wrong_is_said_at_its_field(draft, field, word):
    assert list(draft.problems()) == [field]
    assert word in draft.problems()[field]


def test_without_problems_it_makes_the_box():
    assert GOOD.problems() == {}
    lattice = GOOD.command().lattice
    assert lattice.shape == (4, 3, 3)
    assert lattice.control_points[-1, -1, -1] == pytest.approx([1, 2, 3])


ANGLE = st.floats(-85, 85)


@given(ANGLE, ANGLE, ANGLE)
def test_the_frame_is_that_of_scipy_and_gives_its_angles_back(a, b, c):
    axes = frame((a, b, c))
    assert np.allclose(axes.T, Rotation.from_euler("xyz", [a, b, c], degrees=True).as_matrix())
    assert angles_of(axes) == pytest.approx((a, b, c), abs=1e-5)


def test_a_frame_aligned_to_a_turned_bar_is_turned_like_it_and_right_handed():
    rng = np.random.default_rng(3)
    bar = rng.uniform(-1, 1, (500, 3)) * [5, 2, 0.5]
    turn = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    axes = principal_frame(bar @ turn.T, flat=False)
    assert np.linalg.det(axes) == pytest.approx(1)
    assert abs(axes[0] @ turn[:, 0]) > 0.999
    flat = principal_frame(bar @ turn.T, flat=True)
    assert flat[2] == pytest.approx([0, 0, 1])


def test_points_inside_a_turned_box_are_those_of_its_frame():
    draft = changed(angles=(10.0, 20.0, 30.0), lower=(-1, -1, -1), upper=(1, 1, 1))
    points = np.random.default_rng(4).uniform(-2, 2, (1000, 3))
    turned = Rotation.from_euler("xyz", [10, 20, 30], degrees=True).inv().apply(points)
    expected = (np.abs(turned) <= 1).all(axis=1)
    assert (inside_box(draft.command().lattice, points) == expected).all()
