"""Sets of control points."""

from __future__ import annotations

import pytest

from ffdstudio.project.interaction import selection as s

SHAPE = (4, 3, 2)
ONE = frozenset({(1, 1, 0)})


def test_a_click_selects_one_and_with_toggle_adds_or_removes() -> None:
    assert s.click(ONE, (0, 0, 0)) == {(0, 0, 0)}
    assert s.click(ONE, (0, 0, 0), toggle=True) == ONE | {(0, 0, 0)}
    assert s.click(ONE, (1, 1, 0), toggle=True) == s.NOTHING
    assert s.click(ONE, None) == s.NOTHING
    assert s.click(ONE, None, toggle=True) == ONE


def test_a_band_replaces_adds_or_removes() -> None:
    new = [(0, 0, 0), (1, 1, 0)]
    assert s.band(ONE, new, add=False, remove=False) == set(new)
    assert s.band(ONE, new[:1], add=True, remove=False) == set(new)
    assert s.band(ONE, new, add=False, remove=True) == s.NOTHING


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_rows_and_planes_share_the_other_indices(axis: int) -> None:
    row, plane = s.row(ONE, SHAPE, axis), s.plane(ONE, SHAPE, axis)
    assert len(row) == SHAPE[axis]
    assert len(plane) == 24 // SHAPE[axis]
    assert all(p[k] == 1 - (k == 2) for p in row for k in range(3) if k != axis)
    assert {p[axis] for p in plane} == {1 - (axis == 2)}
    assert row & plane == ONE


def test_all_none_and_inverse() -> None:
    assert len(s.everything(SHAPE)) == 24
    assert s.inverse(ONE, SHAPE) | ONE == s.everything(SHAPE)


def test_grow_takes_neighbours_inside_the_net_and_shrink_undoes_it_inside() -> None:
    assert s.grow(ONE, SHAPE) == {(1, 1, 0), (0, 1, 0), (2, 1, 0), (1, 0, 0), (1, 2, 0), (1, 1, 1)}
    assert s.shrink(s.everything(SHAPE), SHAPE) == s.everything(SHAPE)
    assert s.shrink(s.grow(frozenset({(5, 5)}), (11, 11)), (11, 11)) == {(5, 5)}
    assert s.grow(frozenset({(0,)}), (3,)) == {(0,), (1,)}
