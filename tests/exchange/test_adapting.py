"""Making lattices fit formats: exactly where it can be, else with the error stated."""

import numpy as np
import pytest

from ffdstudio import InputError, Lattice, read_lattice, write_lattice


def box(shape=(6, 5, 4), degrees=(3, 3, 3)):
    rest = Lattice.box([0, 0, 0], [1, 1, 1], shape, degrees)
    bend = 0.1 * np.sin(3 * rest.control_points[..., :1]) * [0, 1, 0.5]
    return rest, rest.moved(rest.control_points + bend)


def difference(old, new, d=3):
    u = np.random.default_rng(5).random((400, d))
    return np.abs(old.evaluate(u) - new.evaluate(u)).max()


def test_knots_are_inserted_where_that_makes_them_uniform(tmp_path):
    rest, current = (lattice.insert_knots(0, [1 / 6]) for lattice in box())
    with pytest.raises(InputError, match="not equally spaced"):
        write_lattice(tmp_path / "a.xyz", rest, current)
    said = write_lattice(tmp_path / "a.xyz", current, adapt="exact")
    assert said.exact
    assert "2 knots were inserted in direction i" in said.reason
    assert difference(current, read_lattice(tmp_path / "a.xyz")[0]) < 1e-14


def test_knots_without_a_common_measure_can_only_be_resampled(tmp_path):
    rest, current = (lattice.insert_knots(0, [1 / np.pi]) for lattice in box())
    with pytest.raises(InputError, match="resample"):
        write_lattice(tmp_path / "a.xyz", rest, current, adapt="exact")
    said = write_lattice(tmp_path / "a.xyz", current, adapt="resample")
    assert not said.exact
    stated = float(said.reason.split()[-1])
    assert 1e-12 < difference(current, read_lattice(tmp_path / "a.xyz")[0]) <= 1.05 * stated


def test_a_resampled_straight_box_is_still_the_identity(tmp_path):
    rest, _ = box(degrees=(2, 2, 2))
    write_lattice(tmp_path / "a.xyz", rest, adapt="resample")
    assert difference(rest, read_lattice(tmp_path / "a.xyz")[0]) < 1e-14


def test_one_net_of_two_is_said_to_be_lost(tmp_path):
    said = write_lattice(tmp_path / "a.xyz", *box())
    assert not said.exact
    assert "one net" in said.reason


def test_two_directions_become_a_slab_on_request(tmp_path):
    rest = Lattice.box([0, 0], [2, 1], shape=(5, 4))
    with pytest.raises(InputError, match="2 directions"):
        write_lattice(tmp_path / "a.xyz", rest)
    assert write_lattice(tmp_path / "a.xyz", rest, adapt="exact").exact
    slab = read_lattice(tmp_path / "a.xyz")[0]
    assert slab.shape == (5, 4, 2)
    assert np.array_equal(slab.control_points[:, :, 0, :2], rest.control_points[..., :2])
    assert np.ptp(slab.control_points[..., 2]) == 1.0


def test_turned_directions_of_a_plane_lattice_are_not_lost_silently(tmp_path):
    rest = Lattice.box([0, 0], [1, 1], shape=(4, 4), axes=[[1, 0, 0], [0, 0, 1]])
    with pytest.raises(InputError, match="coordinate axes"):
        write_lattice(tmp_path / "a.g2", rest)


@pytest.mark.parametrize("name", ["a.g2", "a.splinepy.json", "a.cfg"])
@pytest.mark.parametrize("adapt", ["exact", "resample"])
def test_adapting_does_not_drop_the_axes_of_a_plane_lattice(tmp_path, name, adapt):
    rest = Lattice.box([0, 0], [1, 1], shape=(4, 4), axes=[[1, 0, 0], [0, 0, 1]])
    with pytest.raises(InputError, match=r"coordinate axes; write \.lattice\.json$"):
        write_lattice(tmp_path / name, rest, adapt=adapt)
    assert not (tmp_path / name).exists()


def weighted(lattice):
    weights = lattice.weights.copy()
    weights[1, 1] = 2
    return lattice.moved(weights=weights)


@pytest.mark.parametrize("adapt", ["refuse", "exact", "resample"])
@pytest.mark.parametrize(
    ("name", "lattice", "ways"),
    [
        ("a.xyz", Lattice.box([0], [1], shape=(4,)), ""),
        ("a.cfg", Lattice.box([0], [1], shape=(4,)), ""),
        ("a.xyz", weighted(box()[0]), '"resample"'),
        ("a.xyz", Lattice.box([0, 0], [1, 1], shape=(4, 4)), '"exact" or "resample"'),
        ("a.xyz", box()[0].insert_knots(0, [1 / 6]), '"exact" or "resample"'),
        ("a.xyz", box()[0].insert_knots(0, [1 / np.pi]), '"resample"'),
        ("a.prm", box((4, 4, 4))[1], ""),
    ],
)
def test_only_remedies_that_help_are_offered_and_they_do(tmp_path, name, lattice, ways, adapt):
    if f'"{adapt}"' in ways:
        write_lattice(tmp_path / name, lattice, adapt=adapt)
        return
    with pytest.raises(InputError) as caught:
        write_lattice(tmp_path / name, lattice, adapt=adapt)
    end = f"write .lattice.json, or adapt it with {ways}" if ways else "write .lattice.json"
    assert str(caught.value).endswith(end)


def test_unknown_suffix_and_unknown_adaptation_are_refused(tmp_path):
    rest, _ = box()
    with pytest.raises(InputError, match="no lattice format"):
        write_lattice(tmp_path / "a.step", rest)
    with pytest.raises(InputError, match="adapt must be"):
        write_lattice(tmp_path / "a.xyz", rest, adapt="please")
