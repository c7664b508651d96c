"""What is said of case files is made from the catalog: reference, schema, examples."""

import json
import tomllib

import jsonschema
import pytest

from ffdstudio.optimize.catalog.constraints import CONSTRAINTS
from ffdstudio.optimize.catalog.methods import METHODS
from ffdstudio.optimize.catalog.objectives import OBJECTIVES
from ffdstudio.optimize.spec.codec import schema
from ffdstudio.optimize.spec.reference import reference


def test_the_reference_beside_the_cases_is_that_of_the_catalog(root):
    text = (root / "resources" / "cases" / "README.md").read_text()
    told = text.partition("<!-- catalog -->\n")[2].partition("<!-- end of catalog -->")[0]
    assert told == reference(), "write it anew: ffdstudio optimize --reference"


def test_the_reference_tells_of_every_kind():
    text = reference()
    for kind in (*OBJECTIVES, *CONSTRAINTS, *METHODS):
        assert f'`"{kind.kind()}"`' in text
        assert kind.about() in text
        assert kind.title


def test_every_example_is_in_the_list_and_fits_the_schema(root):
    folder = root / "resources" / "cases"
    text = (folder / "README.md").read_text()
    rule = json.loads(json.dumps(schema()))
    jsonschema.Draft202012Validator.check_schema(rule)
    for path in folder.glob("*.toml"):
        assert f"`{path.name}`" in text
        jsonschema.validate(tomllib.loads(path.read_text()), rule)


@pytest.mark.parametrize(
    ("table", "key", "value"),
    [
        ("shape", "points", 4),
        ("lattice", "colour", "red"),
        ("objective", "kind", "drag"),
        ("budget", "iterations", 0),
    ],
)
def test_the_schema_refuses_what_a_case_cannot_say(root, table, key, value):
    values = tomllib.loads((root / "resources" / "cases" / "contour.toml").read_text())
    values.setdefault(table, {})[key] = value
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(values, json.loads(json.dumps(schema())))
