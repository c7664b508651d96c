"""Fold check of a lattice, against dense sampling and maps with a known determinant."""

import numpy as np
import pytest

from ffdstudio.engine.folds import folds
from ffdstudio.engine.lattice import Lattice

SHAPES = [
    ((5, 4, 3), (3, 2, 2)),
    ((6, 4), (3, 3)),
    ((7,), (3,)),
    ((2, 2, 2), (1, 1, 1)),
    ((3, 4), (1, 2)),
]


def box(shape, degrees):
    return Lattice.box([0, 0, 0], [2, 1, 1], shape=shape, degrees=degrees)


def least_determinant(lattice, count):
    """Least Jacobian determinant over a grid with the ends, on both sides of knots."""
    sides = [
        np.unique(np.clip(np.concatenate([np.linspace(*ends, count), k - 1e-9, k]), *ends))
        for ends, k in zip(lattice.domain, lattice.knots, strict=True)
    ]
    uvw = np.stack([g.ravel() for g in np.meshgrid(*sides, indexing="ij")], axis=-1)
    d = lattice.dimension
    rows = [lattice.evaluate(uvw, np.eye(d, dtype=int)[k]) @ lattice.axes.T for k in range(d)]
    return np.linalg.det(np.stack(rows, axis=-1)).min()


@pytest.mark.parametrize(("shape", "degrees"), SHAPES)
def test_a_fold_that_sampling_sees_is_found_and_no_other_is_claimed(shape, degrees):
    rng = np.random.default_rng(len(shape))
    rest = box(shape, degrees)
    for size in np.linspace(0.02, 0.3, 20):
        moved = rest.moved(rest.control_points + size * rng.normal(size=rest.control_points.shape))
        found = folds(moved, rest)
        least = least_determinant(moved, {1: 401, 2: 61, 3: 17}[rest.dimension])
        assert not found.undecided.any()
        if least < -1e-9:
            assert found.folded.any()
        if least > 0.05:
            assert found.locally_invertible


def test_a_shear_of_any_size_is_invertible():
    rest = box((4, 4, 4), (3, 3, 3))
    points = rest.control_points.copy()
    points[..., 0] += 100 * points[..., 1] ** 3
    assert folds(rest.moved(points), rest).locally_invertible


def test_a_mirrored_lattice_is_folded_against_its_rest_and_sound_by_itself():
    rest = box((4, 3, 3), (2, 2, 2))
    mirrored = rest.moved(rest.control_points * [-1, 1, 1])
    assert folds(mirrored, rest).folded.all()
    assert folds(mirrored).locally_invertible


def test_the_fold_is_reported_in_the_span_where_it_is():
    line = box((6,), (1,))
    points = line.control_points.copy()
    points[2, 0] = points[3, 0] + 0.1
    assert folds(line.moved(points), line).folded.tolist() == [False, False, True, False, False]


def test_a_small_fold_inside_a_span_is_not_lost_between_samples():
    """x = u^3 / 3 - (1 + e) u^2 / 2 + ... with x' = (u - 1/2)^2 - e^2 negative on |u - 1/2| < e."""
    for e in (1e-2, 1e-4):
        # Bezier points of x on [0, 1] from the Bezier coefficients of x'
        slopes = np.array([0.25 - e**2, -0.25 - e**2, 0.25 - e**2])
        x = np.concatenate([[0], np.cumsum(slopes) / 3])
        line = Lattice([3], [[0, 0, 0, 0, 1, 1, 1, 1]], np.stack([x, 0 * x, 0 * x], axis=-1))
        found = folds(line, box((4,), (3,)))
        assert not found.locally_invertible


def test_weights_are_sampled_and_the_answer_says_so():
    rest = box((4, 4, 3), (2, 2, 2))
    weighted = rest.moved(weights=np.linspace(1, 3, 48).reshape(4, 4, 3))
    found = folds(weighted, rest)
    assert found.locally_invertible
    assert "sampled" in str(found)
    points = weighted.control_points.copy()
    points[0, :, :, 0] += 2
    assert folds(weighted.moved(points), rest).folded.any()


def test_high_degrees_stay_decidable():
    lattice = Lattice.box([0, 0, 0], [1, 1, 1], shape=(9, 9, 3), degrees=(8, 8, 2))
    assert folds(lattice).locally_invertible


def test_folded_spans_are_named_by_their_parameters():
    rest = box((6, 4), (3, 3))
    points = rest.control_points.copy()
    points[0, :, 0] = 1.5
    found = folds(rest.moved(points), rest)
    assert found.answer is False
    assert found.where == [[rest.knots[0][[3, 4]].tolist(), [0.0, 1.0]]]
    assert folds(rest).answer is True
    assert folds(rest).where == []


def test_a_large_lattice_is_judged_in_pieces_with_the_same_result(monkeypatch):
    import ffdstudio.engine.folds as module

    rest = box((9, 5, 4), (3, 2, 2))
    rng = np.random.default_rng(3)
    moved = rest.moved(rest.control_points + 0.1 * rng.normal(size=rest.control_points.shape))
    whole = folds(moved, rest)
    monkeypatch.setattr(module, "AT_ONCE", 1)
    pieces = folds(moved, rest)
    assert whole.folded.any()
    assert not whole.folded.all()
    assert np.array_equal(whole.folded, pieces.folded)
    assert np.array_equal(whole.undecided, pieces.undecided)
