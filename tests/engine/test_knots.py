import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffdstudio.engine import knots as kv
from ffdstudio.errors import InputError

COUNTS = st.integers(1, 8).flatmap(lambda p: st.tuples(st.integers(p + 1, p + 9), st.just(p)))


@given(COUNTS)
def test_knots_follow_the_formula_of_the_paper(case):
    count, p = case
    a = count - 1
    q = a + p + 1
    paper = [0 if i <= p else i - p if i <= q - p - 1 else q - 2 * p for i in range(q + 1)]
    ours = kv.clamped_uniform(count, p, 0.0, float(q - 2 * p))
    np.testing.assert_allclose(ours, paper, atol=1e-14 * q)


@given(COUNTS, st.floats(-1e3, 1e3), st.floats(1e-3, 1e3))
def test_knots_span_the_range_of_the_coordinates(case, low, extent):
    u = kv.clamped_uniform(*case, low, low + extent)
    assert u[0] == low
    assert u[-1] == low + extent
    assert (np.diff(u) >= 0).all()


@given(COUNTS)
def test_greville_abscissae_start_and_end_on_the_ends(case):
    u = kv.clamped_uniform(*case, 0.1, 0.7)
    g = kv.greville(u, case[1])
    assert len(g) == case[0]
    assert g[0] == u[0]
    assert g[-1] == u[-1]
    assert (np.diff(g) > 0).all()


def test_spans_hold_their_parameters_and_the_last_one_is_closed():
    u = np.array([0.0, 0, 0, 0.25, 0.25, 0.5, 1, 1, 1])
    at = np.array([0.0, 0.2, 0.25, 0.5, 0.7, 1.0])
    np.testing.assert_array_equal(kv.find_spans(u, 2, at), [2, 2, 4, 5, 5, 5])


def test_spans_step_back_over_empty_ones_at_the_end():
    assert kv.find_spans(np.array([0.0, 0, 1, 1, 1]), 1, np.array([1.0]))[0] == 1


@pytest.mark.parametrize(
    ("count", "degree", "words"),
    [(3, 3, "needs at least 4"), (3, 0, "at least 1"), (3, -1, "at least 1"), (3, 1.5, "whole")],
)
def test_a_degree_that_does_not_fit_is_refused(count, degree, words):
    with pytest.raises(InputError, match=words):
        kv.clamped_uniform(count, degree)


@pytest.mark.parametrize(
    ("knots", "words"),
    [
        ([0, 0, 1, 1], "need 5 knots"),
        ([0, 0, np.nan, 1, 1], "finite"),
        ([0, 0, 2, 1, 1], "not decrease"),
        ([0, 0.1, 0.5, 1, 1], "clamped"),
        ([0, 0, 0, 1, 1], "at most 1"),
        ([0, 0, 0, 0, 0], "at most 1"),
    ],
)
def test_knots_that_are_none_are_refused(knots, words):
    with pytest.raises(InputError, match=words):
        kv.checked(knots, 1, 3)
