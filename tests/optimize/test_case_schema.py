"""The documents of the case files tell of every key, and of no other."""

import re

from ffdstudio.optimize.cases import schema
from ffdstudio.optimize.catalog.methods import METHODS


def test_every_key_is_documented(root):
    text = (root / "resources" / "cases" / "README.md").read_text()
    sections = re.split(r"^### ", text, flags=re.MULTILINE)
    tables = {
        "[shape]": [schema.SHAPE],
        "[lattice]": [schema.LATTICE],
        "[variables]": [schema.VARIABLES],
        "[objective]": [*schema.OBJECTIVES.values(), schema.DEFORMED],
        "[[constraints]]": [*schema.CONSTRAINTS.values(), schema.LIMITS],
        "[method]": [schema.METHOD],
        "[refinement]": [schema.REFINEMENT],
        "[budget]": [schema.BUDGET],
    }
    for name, keys in tables.items():
        (section,) = [part for part in sections if part.startswith((f"`{name}`", name))]
        missing = {key for table in keys for key in table if f"`{key}`" not in section}
        assert not missing, f"{name} says nothing of {missing}"
    for kind in (*schema.OBJECTIVES, *schema.CONSTRAINTS):
        assert f'`"{kind}"`' in text
    assert all(f'"{kind.kind()}"' in text for kind in METHODS)


def test_every_example_is_in_the_list(root):
    folder = root / "resources" / "cases"
    text = (folder / "README.md").read_text()
    assert all(f"`{path.name}`" in text for path in folder.glob("*.toml"))
