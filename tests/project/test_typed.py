"""Typed values, spreads and transforms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ffdstudio.errors import InputError
from ffdstudio.project import commands as c
from ffdstudio.project.document import Document
from ffdstudio.project.interaction import numeric_edits as typed
from ffdstudio.project.interaction.spread import PROFILES, Mirror, Soft, Spread
from ffdstudio.project.interaction.transforms import rotation, scaling
from ffdstudio.project.model import LatticeItem
from tests.project.scenes import BOX

CHOSEN = [(1, 1, 1), (2, 2, 1)]


@pytest.fixture
def document(tmp_path: Path) -> Document:
    document = Document()
    document.do(BOX)
    document.do(c.MovePoints("lattice1", ((1, 1, 1),), ((0.5, 0.6, 0.7),)))
    document.select(CHOSEN)
    return document


def net(document: Document) -> np.ndarray:
    return document.model.lattices[0].current.control_points


REST = BOX.lattice.control_points


def test_a_position_for_many_sets_only_what_is_given(document: Document) -> None:
    before = net(document).copy()
    typed.set_position(document, (None, 0.25, None))
    for point in CHOSEN:
        assert net(document)[point].tolist() == [before[point][0], 0.25, before[point][2]]
    assert len(document.history.entries) == 3


def test_displacements_count_from_rest_or_from_where_points_are(document: Document) -> None:
    before = net(document).copy()
    typed.set_displacement(document, (0.1, None, None), absolute=False)
    for point in CHOSEN:
        np.testing.assert_allclose(net(document)[point], before[point] + [0.1, 0, 0])
    typed.set_displacement(document, (0.0, 0.0, 0.5))
    for point in CHOSEN:
        np.testing.assert_allclose(net(document)[point], REST[point] + [0, 0, 0.5])
    np.testing.assert_allclose(typed.displacement_of(document), [[0, 0, 0.5]] * 2)


def test_weights_are_set_or_multiplied(document: Document) -> None:
    typed.set_weight(document, 2.0)
    typed.set_weight(document, 1.5, relative=True)
    weights = document.model.lattices[0].current.weights
    assert [weights[point] for point in CHOSEN] == [3, 3]
    assert (weights != 1).sum() == 2


@pytest.mark.parametrize("weight", [0.0, -1.0, float("nan"), float("inf")])
def test_an_impossible_weight_changes_nothing(document: Document, weight: float) -> None:
    model = document.model
    with pytest.raises(InputError):
        typed.set_weight(document, weight)
    assert document.model is model
    assert document.editing is None


def test_what_is_typed_as_it_is_makes_no_entry(document: Document) -> None:
    typed.set_weight(document, 1.0)
    typed.set_displacement(document, (0.0, 0.0, 0.0), absolute=False)
    assert len(document.history.entries) == 2


def test_nothing_selected_is_said(document: Document) -> None:
    document.select([])
    with pytest.raises(InputError, match="none of the chosen"):
        typed.set_position(document, (0.0, 0.0, 0.0))
    assert typed.displacement_of(document).shape == (0, 3)


def test_transforms_are_scipys_rotation_and_plain_scaling(document: Document) -> None:
    points, pivot = np.random.default_rng(0).random((20, 3)), np.array([1.0, 2.0, 3.0])
    axis = np.array([1.0, -2.0, 0.5])
    turn = Rotation.from_rotvec(np.radians(37) * axis / np.linalg.norm(axis))
    expected = turn.apply(points - pivot) + pivot
    np.testing.assert_allclose(rotation(axis, 37, pivot)(points), expected, atol=1e-13)
    scaled = scaling([2, 3, 1], pivot)(points)
    np.testing.assert_allclose(scaled, (points - pivot) * [2, 3, 1] + pivot)
    assert np.array_equal(rotation(axis, 0, pivot)(points), points)
    before = net(document)[CHOSEN[0]].copy()
    typed.transform(document, scaling(2, [0, 0, 0]))
    np.testing.assert_allclose(net(document)[CHOSEN[0]], 2 * before)


# ---- spreads ----------------------------------------------------------------------------


def item(frozen: int = 0, shape: tuple[int, ...] = (5, 4, 4)) -> LatticeItem:
    box = c.CreateBox("Box", (-1.0, 0.0, 0.0), (1.0, 1.0, 1.0), shape, (3, 3, 3)).lattice
    return LatticeItem(box, box, frozen, name="Box", key="lattice1")


@pytest.mark.parametrize("profile", sorted(PROFILES))
def test_profiles_fall_from_one_to_zero(profile: str) -> None:
    t = np.linspace(0, 1, 50)
    share = PROFILES[profile](t)
    assert share[0] == 0
    assert share[-1] == 1
    assert (np.diff(share) >= 0).all()


def test_without_options_only_the_selected_move_and_plainly() -> None:
    spread = Spread(item(), CHOSEN)
    assert spread.points == tuple(CHOSEN)
    assert spread.plain


def test_frozen_points_never_move() -> None:
    spread = Spread(item(frozen=1), [(0, 0, 0), (1, 1, 1)], Soft(10.0), Mirror(0))
    assert all(0 < p[0] < 4 and 0 < p[1] < 3 and 0 < p[2] < 3 for p in spread.points)


def test_a_mirrored_rotation_is_the_mirror_image() -> None:
    lattice = item()
    spread = Spread(lattice, [(1, 1, 1)], mirror=Mirror(0))
    start = np.array([lattice.current.control_points[p] for p in spread.points])
    moved = spread.place(start, rotation([0, 0, 1], 20, [-0.5, 0.0, 0.0]))
    assert spread.points == ((1, 1, 1), (3, 1, 1))
    np.testing.assert_allclose(moved[1], moved[0] * [-1, 1, 1], atol=1e-15)


def test_where_both_sides_are_selected_each_follows_its_own() -> None:
    lattice = item()
    spread = Spread(lattice, [(1, 1, 1), (3, 1, 1)], mirror=Mirror(0))
    start = np.array([lattice.current.control_points[p] for p in spread.points])
    moved = spread.place(start, lambda points: points + [0.1, 0.2, 0.3])
    np.testing.assert_allclose(moved - start, [[0.1, 0.2, 0.3]] * 2, atol=1e-15)


def test_points_without_a_partner_move_alone() -> None:
    spread = Spread(item(), [(1, 1, 1)], mirror=Mirror(0, at=0.3))
    assert spread.points == ((1, 1, 1),)
