"""Folded nets are refused before anything is searched for; bent ones never are."""

from itertools import permutations

import numpy as np
import pytest

from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.folds import folds
from ffdstudio.engine.inversion.tangle import inside_out, refuse_tangled
from ffdstudio.errors import InputError
from tests.engine.nets import CURVED, quarter_cylinder, random_lattice
from tests.engine.test_embedding import polar_net

WAY_AROUND = [(0, 0), (1, 0), (1, 1), (0, 1)]
CUBE = np.array([(*xy, z) for z in (0, 1) for xy in WAY_AROUND])


def spanned(order, shape=(3, 4, 3)):
    """A net spread evenly between the corners of the unit cube, taken in some order."""
    cage = np.empty((2, 2, 2, 3))
    for place, corner in zip(CUBE, order, strict=True):
        cage[tuple(place)] = CUBE[corner]
    lattice = Lattice([1] * 3, [[0, 0, 1, 1]] * 3, cage)
    for axis, count in enumerate(shape):
        for _ in range(count - 2):
            lattice = lattice.elevate_degree(axis)
    return lattice


def test_corners_in_a_wrong_order_are_refused_whichever_order_that_is():
    rng = np.random.default_rng(0)
    orders = rng.permutation(list(permutations(range(1, 8))))[:150]
    refused = 0
    for order in orders:
        lattice = spanned((0, *order), (2, 2, 2))
        found = folds(lattice)
        try:
            refuse_tangled(lattice)
        except InputError:
            refused += 1
            assert found.folded.any()  # never in vain
        else:
            assert inside_out(lattice) == 0
    assert refused > 130


@pytest.mark.parametrize("order", [(0, 1, 3, 2, 4, 5, 7, 6), (0, 1, 2, 3, 4, 5, 7, 6)])
def test_points_are_not_embedded_in_a_net_with_swapped_corners(order):
    with pytest.raises(InputError, match=r"is folded: .* most likely its corners"):
        embed(spanned(order), [[0.5, 0.5, 0.5]])


def test_a_bow_tie_in_the_plane_is_refused():
    net = Lattice.box([0, 0], [1, 1], shape=(5, 3)).control_points.copy()
    net[:, -1] = net[::-1, -1]
    tied = Lattice.box([0, 0], [1, 1], shape=(5, 3)).moved(net)
    with pytest.raises(InputError, match=r"along i, then around the face$"):
        embed(tied, [[0.5, 0.5, 0.0]])


def test_a_line_that_runs_back_is_refused():
    line = Lattice.box([0], [1], shape=(4,), degrees=(1,))
    net = line.control_points.copy()
    net[[1, 2]] = net[[2, 1]]
    with pytest.raises(InputError, match="back and forth"):
        embed(line.moved(net), [[0.5, 0, 0]])


@pytest.mark.parametrize("mirror", [1, -1])
def test_bent_weighted_polar_and_mirrored_nets_pass(mirror):
    rng = np.random.default_rng(1)
    nets = [make() for make in CURVED.values()] + [polar_net(), quarter_cylinder()]
    nets += [random_lattice(rng, weighted=w, spread=s) for w in (0, 1) for s in (0.02, 0.1, 0.3)]
    for net in nets:
        refuse_tangled(net.moved(net.control_points * [mirror, 1, 1]))


def test_a_net_that_one_pulled_control_point_folds_is_still_used():
    box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(6, 4, 4))
    net = box.control_points.copy()
    net[2, 2, 2] += 3
    lattice = box.moved(net)
    assert 0 < inside_out(lattice) < 0.1
    refuse_tangled(lattice)


def test_a_shuffled_net_is_refused_though_its_corners_are_right():
    box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(6, 5, 4))
    net = box.control_points.copy()
    net[1:-1] = net[1:-1][::-1]
    with pytest.raises(InputError, match="folded"):
        embed(box.moved(net), [[0.5, 0.5, 0.5]])


def test_many_knot_spans_are_looked_at_on_a_thinned_grid():
    box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(60, 40, 30), degrees=(3, 2, 1))
    bent = box.moved(box.control_points + 0.05 * np.sin(4 * box.control_points[..., ::-1]))
    refuse_tangled(bent)
    net = bent.control_points.copy()
    net[:, -1] = net[::-1, -1]
    with pytest.raises(InputError, match="folded"):
        refuse_tangled(bent.moved(net))
