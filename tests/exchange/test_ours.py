"""Our own lattice file: every bit survives, everything unexpected is one sentence."""

import json
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffdstudio import InputError, Lattice, read_lattice, write_lattice
from ffdstudio.exchange import read_lattice_file

AWKWARD = [0.1, 1 / 3, 5e-324, 1.7976931348623157e308, -0.0, 2.0**-1074 * 3, 123456789.123456789]


def example(shape=(4, 3, 2)):
    rng = np.random.default_rng(7)
    rest = Lattice.box([-1, 0, 2], [3, 1, 2.5], shape=shape)
    points = rest.control_points + 0.01 * rng.standard_normal(rest.control_points.shape)
    return rest, rest.moved(points, 0.5 + rng.random(rest.shape))


@pytest.mark.parametrize("shape", [(4, 3, 3), (4, 3), (5,)])
def test_every_bit_survives(tmp_path, shape):
    rest, current = example(shape)
    path = tmp_path / "a.lattice.json"
    assert write_lattice(path, rest, current, frozen=1, units="mm").exact
    found = read_lattice_file(path)
    assert (found.rest, found.current) == (rest, current)
    assert (found.frozen, found.units) == (1, "mm")


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=24, max_size=24))
@settings(max_examples=50, deadline=None)
def test_any_finite_double_comes_back_with_its_bits(tmp_path_factory, numbers):
    rest = Lattice.box([0, 0, 0], [1, 1, 1], shape=(2, 2, 2))
    numbers[: len(AWKWARD)] = AWKWARD
    current = rest.moved(np.array(numbers).reshape(2, 2, 2, 3))
    path = tmp_path_factory.mktemp("bits") / "a.lattice.json"
    write_lattice(path, rest, current)
    back = read_lattice(path)[1].control_points
    assert np.array_equal(back.view(np.int64), current.control_points.view(np.int64))


def test_one_moved_control_point_changes_one_line(tmp_path):
    rest = Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 3, 2))
    points = rest.control_points.copy()
    write_lattice(tmp_path / "a.lattice.json", rest)
    points[1, 2, 0] += 0.25
    write_lattice(tmp_path / "b.lattice.json", rest, rest.moved(points))
    texts = [(tmp_path / f"{name}.lattice.json").read_text().splitlines() for name in "ab"]
    assert sum(a != b for a, b in zip(*texts, strict=True)) == 1


def test_reading_gives_exactly_two_lattices(tmp_path):
    rest, current = example()
    write_lattice(tmp_path / "a.lattice.json", rest, current)
    assert len(read_lattice(tmp_path / "a.lattice.json")) == 2


def edit(key, value):
    def change(data):
        data[key] = value

    return change


def edit_rest(key, value):
    def change(data):
        data["rest"][key] = value

    return change


def edit_point(value):
    def change(data):
        data["current"]["control_points"][3][1] = value

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (edit("version", 3), "newer FFD Studio"),
        (edit("version", 0), "no version 0"),
        (edit("version", "1"), '"version" must be a whole number'),
        (edit("version", True), '"version" must be a whole number'),
        (edit("format", "other"), "no lattice file of ours"),
        (edit("degrees", [3, 2]), "equally many"),
        (edit("degrees", [3, 2.0, 1]), "whole numbers"),
        (edit("degrees", [4, 2, 1]), "degree 4"),
        (edit("degrees", [0, 2, 1]), "degree 0"),
        (edit("shape", [4, 3, 3]), "36 rows"),
        (edit("shape", [10**9, 10**9, 10**9]), "rows"),
        (edit("shape", [-4, 3, -2]), "must have"),
        (edit("shape", []), "1 to 3 numbers"),
        (edit("frame", [[1, 0, 0], [1, 0, 0], [0, 0, 1]]), "right angles"),
        (edit("knots", [[0, 1], [0, 1], [0, 1]]), "knots"),
        (edit("knots", [[0, "a"], [0, 1], [0, 1]]), "list of numbers"),
        (edit("knots", 3), "must be a list"),
        (edit("frozen_layers", -1), "-1 frozen layers"),
        (edit("frozen_layers", 1.5), "whole number"),
        (edit("units", None), '"units" must be a text'),
        (edit("surplus", 1), '"surplus" is unknown'),
        (edit("rest", []), '"rest" must be an object'),
        (edit_rest("weights", [[1, 1]] * 11), "12 rows"),
        (edit_rest("weights", [[1, 0]] * 12), "positive"),
        (edit_rest("control_points", [[0, 0]] * 24), "3 numbers"),
        (edit_point("1.0"), "numbers"),
        (edit_point(True), "numbers"),
        (edit_point(None), "numbers"),
        (edit_point(10**400), "too large"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(tmp_path, change, words):
    path = tmp_path / "a.lattice.json"
    write_lattice(path, *example())
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=re.escape(words)) as error:
        read_lattice(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"version": 1', '"version": NaN', "NaN"),
        ("[-1.0,", "[Infinity,", "Infinity"),
        ("[-1.0,", "[1e999,", "1e999"),
        ('"version": 1,', '"version": 1, "version": 1,', '"version" occurs twice'),
        ("{", "[{", "JSON"),
        ('"units": ""', '"units": "' + "[" * 200_000, "JSON"),
    ],
)
def test_json_that_readers_would_not_agree_about_is_refused(tmp_path, old, new, words):
    path = tmp_path / "a.lattice.json"
    write_lattice(path, *example())
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(InputError, match=re.escape(words)):
        read_lattice(path)


def test_every_truncation_is_refused(tmp_path):
    path = tmp_path / "a.lattice.json"
    write_lattice(path, *example((2, 2)))
    whole = path.read_bytes()
    for length in range(0, len(whole) - 2, 7):
        path.write_bytes(whole[:length])
        with pytest.raises(InputError):
            read_lattice(path)


def test_deep_nesting_is_refused(tmp_path):
    path = tmp_path / "a.lattice.json"
    path.write_text('{"format": ' + "[" * 100_000 + "]" * 100_000 + "}")
    with pytest.raises(InputError, match="nested"):
        read_lattice(path)


@pytest.mark.parametrize(
    ("options", "cause"),
    [
        ({"frozen": 1.5}, "whole number, got 1.5"),
        ({"frozen": True}, "whole number, got True"),
        ({"frozen": "1"}, "whole number, got '1'"),
        ({"frozen": -1}, "-1 frozen layers"),
        ({"frozen": 2}, "2 frozen layers on each face leave nothing of 5x4x3 points"),
        ({"units": None}, "units of a lattice must be a text, got None"),
        ({"current": "bent"}, "a lattice is needed, got 'bent'"),
        ({"tag": "WING"}, "FFD Studio lattice has no option tag"),
    ],
)
def test_what_could_not_be_read_back_is_not_written(tmp_path, options, cause):
    path = tmp_path / "a.lattice.json"
    with pytest.raises(InputError, match=cause):
        write_lattice(path, Lattice.box([0, 0, 0], [1, 1, 1], shape=(5, 4, 3)), **options)
    assert not path.exists()


def test_frozen_layers_may_be_numpys_number(tmp_path):
    path = tmp_path / "a.lattice.json"
    write_lattice(path, Lattice.box([0], [1], shape=(4,)), frozen=np.int64(1))
    assert read_lattice_file(path).frozen == 1


@pytest.mark.parametrize("path", [None, 5, b"a.lattice.json"])
def test_what_is_no_path_is_refused_in_words(path):
    with pytest.raises(InputError, match="a path must be"):
        write_lattice(path, Lattice.box([0], [1], shape=(4,)))
    with pytest.raises(InputError, match="a path must be"):
        read_lattice_file(path)


def rings():
    """A ring in its frame, moved, and a periodic net with weights and no frame."""
    ring = Lattice.cylinder((1, 2), heights=(0, 1), shape=(3, 8, 2), axis=[1, 2, 0.5])
    plain = Lattice.of_parts(
        {k: v for k, v in ring.parts().items() if k not in ("frame", "reference")}
    )
    weights = np.random.default_rng(0).uniform(0.5, 2, ring.shape)
    return {
        "frame": (ring, ring.moved(ring.control_points + 0.1, weights)),
        "net": (plain.moved(weights=weights), plain.moved(plain.control_points * 1.1, weights)),
    }


@pytest.mark.parametrize("kind", ["frame", "net"])
def test_periodic_lattices_come_back_to_the_bit(tmp_path, kind):
    rest, current = rings()[kind]
    path = tmp_path / "ring.lattice.json"
    assert write_lattice(path, rest, current, frozen=1, open_faces=[(0, 1), (2, 0), (2, 1)]).exact
    found = read_lattice_file(path)
    assert (found.rest, found.current) == (rest, current)
    assert found.rest.periodic == (False, True, False)
    assert set(found.open_faces) == {(0, 1), (2, 0), (2, 1), (1, 0), (1, 1)}
    assert '"version": 2' in path.read_text()
    assert write_lattice(tmp_path / "again.lattice.json", *read_lattice(path), frozen=1,
                         open_faces=found.open_faces).exact  # fmt: skip
    assert (tmp_path / "again.lattice.json").read_bytes() == path.read_bytes()


def test_what_needs_no_new_version_is_written_in_the_old_one_and_read(tmp_path):
    path = tmp_path / "box.lattice.json"
    write_lattice(path, Lattice.box([0, 0], [1, 1], shape=(3, 3)))
    text = path.read_text()
    assert '"version": 1' in text
    path.write_text(text.replace('"units"', '"periodic": [true, false], "units"'))
    with pytest.raises(InputError, match='"periodic" is unknown in version 1'):
        read_lattice(path)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"kind": "cylinder"', '"kind": "torus"', "torus"),
        ('"periodic": [false, true, false]', '"periodic": [0, 1, 0]', "true or false"),
        ('"periodic": [false, true, false]', '"periodic": [false, true]', "3 directions"),
        ('"periodic": [false, true, false]', '"periodic": [false, false, false]', "knots"),
        ('"reference": {', '"reverence": {', "unknown"),
        ('"origin": [0.0', '"origin": [0.0, 1.0', "3 finite numbers"),
        ('"origin": [0.0', '"origin": [1e999', "finite|large|number"),
    ],
)
def test_a_damaged_ring_is_refused_in_one_sentence(tmp_path, old, new, words):
    path = tmp_path / "ring.lattice.json"
    write_lattice(path, *rings()["frame"])
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=words) as caught:
        read_lattice(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_other_formats_say_that_a_seam_is_lost_and_offer_the_nearest_thing(tmp_path):
    rest, current = rings()["net"]
    path = tmp_path / "ring.g2"
    with pytest.raises(InputError, match=r'direction j is periodic.*adapt it with "exact"'):
        write_lattice(path, rest, current)
    exactness = write_lattice(path, current, current, adapt="exact")
    assert "direction j got ends at its seam" in str(exactness)
    u = np.random.default_rng(1).uniform(*rest.domain.T, (200, 3))
    assert np.abs(read_lattice(path)[1].evaluate(u) - current.evaluate(u)).max() < 1e-14
    rest, current = rings()["frame"]
    with pytest.raises(InputError, match="follows a cylinder"):
        write_lattice(path, rest, current, adapt="exact")
    exactness = write_lattice(path, rest, rest, adapt="resample")
    assert not exactness.exact
    off = np.abs(read_lattice(path)[0].evaluate(u) - rest.evaluate(u)).max()
    assert 1e-4 < off < 0.05
