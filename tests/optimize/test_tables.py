"""What a key of a case file may be is said once; everything else is refused."""

import re

import pytest

from ffdstudio.errors import InputError
from ffdstudio.optimize.cases import tables as t


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        (t.text(), ["a"], ["", " ", 1, ["a"], None]),
        (t.flag(), [True, False], [0, 1, "true"]),
        (t.whole(least=1, most=9), [1, 9], [0, 10, 1.0, 1.5, True, "1", 1e300]),
        (t.number(least=0, most=2), [0, 1.5, 2], [-1, 2.1, "1", True, float("nan"), float("inf")]),
        (t.number(above=0), [1e-9], [0, -1, 1e300]),
        (t.word(("i", "j")), ["i"], ["k", ["i"], 1]),
        (t.words(("i", "j")), [["i"], ["j", "i"]], [[], ["i", "i"], [["i"]], "i"]),
        (t.several(t.number(), 2, 2), [[1, 2.5]], [[1], [1, 2, 3], 1, [1, "2"], [[1], 2]]),
        (
            t.several(t.several(t.whole(least=0), 1, 3), 0),
            [[], [[1, 2]]],
            [[1, 2], [["a", 1]], [[1.5, 0]]],
        ),
    ],
)
def test_values_that_can_be_are_taken_and_others_are_not(key, right, wrong):
    for value in right:
        assert t.Table({"a": value}, "x", {"a": key})["a"] == value
    for value in wrong:
        with pytest.raises(InputError, match=re.escape("[x] a must be")):
            t.Table({"a": value}, "x", {"a": key})


def test_a_default_makes_a_key_one_that_may_be_absent():
    assert t.Table({}, "x", {"a": t.whole() | None})["a"] is None
    with pytest.raises(InputError, match="lacks a"):
        t.Table({}, "x", {"a": t.whole()})


def test_a_key_nobody_knows_is_told_with_those_that_are():
    with pytest.raises(InputError, match="knows no c; it knows a, b"):
        t.Table({"c": 1}, "x", {"a": t.whole() | 1, "b": t.whole() | 1})
    with pytest.raises(InputError, match="must be a table"):
        t.Table([1], "x", {})


def test_an_error_quotes_no_more_than_a_line():
    with pytest.raises(InputError) as error:
        t.Table({"a": list(range(1000))}, "x", {"a": t.whole()})
    assert len(str(error.value)) < 150
