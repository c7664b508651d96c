"""JSON, TOML and .npy of strangers: what is read, and that the rest is one sentence."""

import io
import tomllib

import numpy as np
import pytest

from ffdstudio import InputError
from ffdstudio.containers import npy, strictjson, stricttoml
from ffdstudio.limits import MAX_NESTING


def saved(array):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


@pytest.mark.parametrize("kind", ["f8", "f4", "i4", "u1", "?", ">f8", "i8"])
@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 3), (2, 0, 3), (2, 3, 4)])
@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_come_back_as_numpy_reads_them(kind, shape, order):
    array = np.asarray(np.random.default_rng(1).integers(0, 2, shape).astype(kind), order=order)
    data = saved(array)
    expected, found = np.load(io.BytesIO(data)), npy.loads(data)
    assert found.dtype == expected.dtype
    assert found.shape == expected.shape
    assert found.tobytes() == expected.tobytes()
    assert found.flags.writeable


def with_header(text):
    head = text.encode()
    return b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + bytes(24)


HEADER = "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }\n"


@pytest.mark.parametrize(
    "header",
    [
        HEADER.replace("(3,)", "(True, 3)"),
        HEADER.replace("(3,)", "(-3, -1)"),
        HEADER.replace("(3,)", "(" + "(" * 3000),
        HEADER.replace("(3,)", f"({10**17}, {10**17}, 0, 3)"),
        HEADER.replace("(3,)", "(" + "1, " * 40 + "3)"),
        HEADER.replace("(3,)", "(3,"),
        HEADER.replace("<f8", "O"),
        HEADER.replace("<f8", "<f3"),
        HEADER.replace("'<f8'", "[('a', '<f8')]"),
        HEADER.replace("False", "__import__('os')"),
        HEADER[:-10],
        "",
    ],
)
def test_a_header_that_numpy_save_never_writes_is_refused(header):
    with pytest.raises(ValueError, match=r"."):
        npy.loads(with_header(header))


def test_the_unchanged_header_is_read():
    assert npy.loads(with_header(HEADER)).tolist() == [0, 0, 0]


@pytest.mark.parametrize("item", ["[", '{"a":', '[{"a":'])
@pytest.mark.parametrize("depth", [MAX_NESTING + 1, 600, 200_000])
def test_deep_json_is_one_sentence(item, depth):
    with pytest.raises(InputError, match="nested too deeply"):
        strictjson.loads(b'{"a":' + item.encode() * depth, "x.json")


def test_brackets_in_quotes_do_not_count():
    text = "[" * 500 + '\\"' + "{" * 500
    assert strictjson.loads(f'{{"a": "{text}"}}'.encode(), "x")["a"] == text.replace('\\"', '"')


def test_a_json_file_of_nothing_but_empty_objects_is_refused_unparsed():
    data = b'{"a":[' + b"{}," * 2_000_001 + b"{}]}"
    with pytest.raises(InputError, match="more than 2,000,000 lists and objects"):
        strictjson.loads(data, "x.json")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = " + "[" * 100_000, "nested too deeply"),
        ("x = " + "{a=" * 5_000, "nested too deeply"),
        (".".join("a" * 500) + " = 1", "nested too deeply"),
        ("[" + ".".join("a" * 500) + "]", "nested too deeply"),
        ("x = " + "9" * 5000, "too long"),
        ("x = ", "no TOML"),
        ("\0", "no TOML"),
        ("x = [1, 2", "no TOML"),
    ],
)
def test_wrong_toml_is_one_sentence(text, words):
    with pytest.raises(InputError, match=words) as error:
        stricttoml.loads(text.encode(), "x.toml")
    assert len(str(error.value).splitlines()) == 1


def test_right_toml_is_what_tomllib_says():
    text = '[a]\nb = [[1, 2], [3]]\nc = "[[["\n[[d]]\ne = 1979-05-27\n'
    assert stricttoml.loads(text.encode(), "x") == tomllib.loads(text)
