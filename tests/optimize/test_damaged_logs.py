"""A log that someone else has written or a disk has damaged: read, or refused in one sentence."""

import json

import pytest

from ffdstudio import InputError
from ffdstudio.optimize.runs.record import LOG, read_log

LATTICE = {
    "degrees": [1, 1],
    "knots": [[0, 0, 1, 1], [0, 0, 1, 1]],
    "control_points": [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]]],
    "axes": [[1, 0, 0], [0, 1, 0]],
}
GOOD = {
    "kind": "iterate", "evaluation": 1, "iteration": 0, "level": 0, "variables": 2, "cost": 0.5,
    "gradient": 1.0, "flow": 1, "seconds": 0.1, "y": [0.0, 1], "measures": {"rms": 1}, "note": "x",
    "lattice": LATTICE,
}  # fmt: skip
END = {
    **{k: GOOD[k] for k in ("evaluation", "iteration", "level", "variables", "cost")},
    "kind": "end",
    "ending": {"reason": "converged"},
}


def log(folder, *lines):
    texts = [line if isinstance(line, str) else json.dumps(line) for line in lines]
    (folder / LOG).write_text("\n".join([*texts, ""]))
    return folder


def test_a_good_log_is_read(tmp_path):
    history = read_log(log(tmp_path, GOOD, GOOD | {"cost": float("nan")}, END))
    assert history.lattice(0).shape == (2, 2)
    assert len(history.records) == 3


WRONG = [
    *({name: value} for name in GOOD for value in (None, True, [[1]], {"a": {}}, {"a": "b"})),
    *({name: "1"} for name in GOOD if name not in ("kind", "note")),
    *({name: 1.5} for name in ("kind", "evaluation", "level", "y", "measures", "lattice")),
    {"y": ["a"]}, {"y": [None]}, {"y": [True]}, {"measures": [1]}, {"unknown": 1},
    {"ending": "converged"}, {"ending": {}}, {"ending": {"reason": "bored"}}, {"ending": [1]},
    {"lattice": LATTICE | {"degrees": [1]}},
    {"lattice": LATTICE | {"degrees": ["1", 1]}},
    {"lattice": LATTICE | {"degrees": None}},
    {"lattice": LATTICE | {"knots": [[0, 0, 1]]}},
    {"lattice": LATTICE | {"control_points": [[[0, 0]]]}},
    {"lattice": LATTICE | {"weights": [["a"]]}},
    {"lattice": LATTICE | {"axes": 10**400}},
    {"lattice": LATTICE | {"more": 1}},
    {"lattice": {}},
]  # fmt: skip


@pytest.mark.parametrize("change", WRONG)
def test_a_field_of_another_type_names_its_line(tmp_path, change):
    with pytest.raises(InputError, match="line 2 of"):
        read_log(log(tmp_path, GOOD, GOOD | change))


TEXTS = ["{", "[]", "1", "null", "[" * 5000, '{"kind": ' + "[" * 300 + "]" * 300 + "}", "\udc80"]


@pytest.mark.parametrize("text", [*TEXTS, "9" * 5000, '{"cost": ' + "9" * 5000 + "}"])
def test_a_line_that_is_no_object_names_its_line(tmp_path, text):
    (tmp_path / LOG).write_bytes(text.encode("utf-8", "surrogateescape") + b"\n")
    with pytest.raises(InputError, match="line 1 of"):
        read_log(tmp_path)
