"""Every public result has the same bits on any number of cores."""

import numpy as np
import pytest

from ffdstudio import threads
from ffdstudio.engine import Lattice, embed

COUNT = 60_000


def nets():
    rng = np.random.default_rng(0)
    box = Lattice.box([0, 0, 0], [1, 1, 1], (8, 6, 4), (3, 3, 3))
    fine = Lattice.box([0, 0, 0], [1, 1, 1], (20, 20, 12), (3, 3, 3))
    return {
        "box": box,
        "curved": box.moved(box.control_points + 0.05 * np.sin(3 * box.control_points[..., ::-1])),
        "weighted": box.moved(weights=rng.uniform(0.5, 2, box.shape)),
        "many cells": fine,
        "ring": Lattice.cylinder((0.2, 0.8), heights=(0, 1), shape=(4, 9, 3)),
    }


def results(lattice):
    """What a lattice and points give: all that is public and has to do with many points."""
    rng = np.random.default_rng(1)
    x = rng.uniform(-0.1, 1.1, (COUNT, 3))
    current = lattice.moved(
        lattice.control_points + 0.05 * rng.normal(size=lattice.control_points.shape),
        rng.uniform(0.5, 2, lattice.shape),
    )
    plain = lattice.moved(current.control_points)
    s = rng.normal(size=x.shape)
    found = embed(lattice, x)
    finer = lattice.insert_knots(0, [0.35])
    out = {
        "parameters": found.parameters,
        "inside": found.inside,
        "residual": found.residual,
        "iterations": found.iterations,
    }
    for name, state in (("plain", plain), ("turned", current)):
        out[f"deform {name}"] = found.deform(state)
        out[f"pullback {name}"] = found.jacobian_pullback(state, s)
        out[f"weight pullback {name}"] = found.weight_pullback(state, s)
        out[f"product {name}"] = found.jacobian_product(state, current.control_points)
        out[f"weight product {name}"] = found.weight_product(state, current.weights)
        drag = found.drag(state, [3, 17])
        out[f"drag {name}"] = drag.move([0.1, 0.2, 0.3], found.deform(state))
        out[f"jacobian {name}"] = found.jacobian(state).data
    out["refined"] = found.refined(finer).deform(current.insert_knots(0, [0.35]))
    return out


@pytest.fixture
def cores(monkeypatch):
    """Let the pool have so many threads."""

    def set_cores(count):
        monkeypatch.setattr(threads, "count", lambda: count)
        threads._pool.cache_clear()

    yield set_cores
    threads._pool.cache_clear()


@pytest.mark.parametrize("name", nets())
def test_the_bits_do_not_depend_on_the_number_of_threads(cores, name):
    cores(1)
    alone = results(nets()[name])
    for count in (2, 3, 8):
        cores(count)
        together = results(nets()[name])
        for key, value in alone.items():
            assert value.tobytes() == together[key].tobytes(), (key, count)


def test_repeated_pullbacks_have_the_same_bits(cores):
    cores(8)
    lattice = nets()["weighted"]
    x = np.random.default_rng(2).random((COUNT, 3))
    found, s = embed(lattice, x), np.random.default_rng(3).normal(size=(COUNT, 3))
    first = found.jacobian_pullback(lattice, s)
    for _ in range(5):
        assert found.jacobian_pullback(lattice, s).tobytes() == first.tobytes()


def test_sums_over_many_chunks_are_cut_alike_on_any_number_of_cores(cores):
    """Enough points that a cut by threads would part the sums elsewhere."""
    lattice = nets()["weighted"]
    rng = np.random.default_rng(4)
    x, s = rng.random((300_000, 3)), rng.normal(size=(300_000, 3))
    found = embed(lattice, x)
    assert found._deformer.order.chunks > 16
    sums = []
    for count in (1, 2, 3, 8):
        cores(count)
        both = found.jacobian_pullback(lattice, s), found.weight_pullback(lattice, s)
        sums.append(b"".join(part.tobytes() for part in both))
    assert len(set(sums)) == 1
