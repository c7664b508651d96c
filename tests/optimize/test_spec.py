"""One description: the same from TOML, JSON and back, for every row of the catalog."""

from __future__ import annotations

import json
import tomllib

import msgspec
import pytest
from msgspec import inspect

from ffdstudio.errors import InputError
from ffdstudio.optimize.catalog.constraints import CONSTRAINTS
from ffdstudio.optimize.catalog.indicators import INDICATORS
from ffdstudio.optimize.catalog.methods import METHODS
from ffdstudio.optimize.catalog.metrics import METRICS
from ffdstudio.optimize.catalog.objectives import OBJECTIVES
from ffdstudio.optimize.spec.codec import from_values, read_study, to_toml, to_values
from ffdstudio.optimize.spec.parts import BudgetSpec, LatticeSpec, ShapeSpec, VariablesSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from tests.optimize.catalog_rows import EVERY, study


@pytest.mark.parametrize("spec", EVERY.values(), ids=list(EVERY))
def test_toml_and_json_give_back_the_same_study(spec, tmp_path):
    assert from_values(tomllib.loads(to_toml(spec))) == spec
    assert from_values(json.loads(json.dumps(to_values(spec)))) == spec
    (tmp_path / "case.toml").write_text(to_toml(spec))
    assert read_study(tmp_path / "case.toml") == spec
    assert hash(read_study(tmp_path / "case.toml")) == hash(spec)


def test_every_row_of_the_catalog_is_tried_here():
    assert {type(s.objective) for s in EVERY.values()} == set(OBJECTIVES)
    assert {type(c) for s in EVERY.values() for c in s.constraints} == set(CONSTRAINTS)
    assert {type(s.method) for s in EVERY.values()} == set(METHODS)
    assert {s.method.metric for s in EVERY.values()} == {m.name for m in METRICS}
    used = {s.refinement.indicator for s in EVERY.values() if s.refinement}
    assert used == {i.name for i in INDICATORS}


PARTS = (ShapeSpec, LatticeSpec, VariablesSpec, RefinementSpec, BudgetSpec)


@pytest.mark.parametrize("kind", [*PARTS, *OBJECTIVES, *CONSTRAINTS, *METHODS])
def test_every_field_has_a_title_and_says_what_it_means(kind):
    for field in msgspec.structs.fields(kind):
        info = inspect.type_info(field.type)
        assert isinstance(info, inspect.Metadata), field.name
        said = info.extra_json_schema
        assert said["title"], field.name
        assert said["description"][-1] != ".", field.name
        assert said["title"][0].isupper() or said["title"][0] == "x"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"objectiv": {}}, r"knows no \[objectiv\] \(did you mean objective\?\)"),
        ({"objective": {"kind": "contuor", "target": "a"}}, r"\(did you mean contour\?\)"),
        ({"objective": {"kind": "contour", "taget": "a"}}, r"no taget \(did you mean target\?\)"),
        ({"constraints": [{"kind": "max thickness", "lower": 1}]}, "did you mean max-thickness"),
        ({"method": {"name": "gauss newton"}}, "did you mean gauss-newton"),
        ({"method": {"metric": "h3"}}, r"\[method\] metric must be one of"),
        ({"budget": {"iterations": 0}}, r"iterations must be a whole number, at least 1, got 0"),
        ({"budget": {"iterations": True}}, "iterations must be a whole number"),
        ({"budget": {"tolerance": float("nan")}}, "tolerance must be a number"),
        ({"lattice": {"shape": [5]} | {"degrees": [3, 1]}}, "1 directions need as many, got 2"),
        ({"lattice": {}}, "lacks shape, or the name of a file"),
        ({"variables": {"directions": ["y", "y"]}}, "different words"),
        ({"refinement": {"variables": list(range(99))}}, "got "),
        ({"objective": [1]}, r"\[objective\] must be a table"),
    ],
)
def test_what_cannot_be_is_told_with_table_key_and_a_near_word(change, words):
    values = to_values(study()) | change
    with pytest.raises(InputError, match=words) as error:
        from_values(values)
    assert len(str(error.value)) < 250


def test_a_study_is_a_value_that_cannot_change():
    spec = study()
    with pytest.raises(AttributeError):
        spec.budget = BudgetSpec(iterations=1)
    assert spec == study()
    assert len({spec, study()}) == 1
