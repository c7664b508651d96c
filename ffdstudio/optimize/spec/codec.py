"""Descriptions in files: TOML and JSON, and the schema of both.

Only what differs from its default is written, so that a file says what matters.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import msgspec

from ffdstudio.containers import stricttoml
from ffdstudio.errors import InputError
from ffdstudio.files import read_bytes
from ffdstudio.optimize.catalog.constraints import CONSTRAINTS
from ffdstudio.optimize.catalog.methods import METHODS
from ffdstudio.optimize.catalog.objectives import OBJECTIVES
from ffdstudio.optimize.spec.limits import ConstraintSpec
from ffdstudio.optimize.spec.parts import BudgetSpec, LatticeSpec, ShapeSpec, VariablesSpec
from ffdstudio.optimize.spec.reading import part, row
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.optimize.spec.words import near

SCHEMA = "https://json-schema.org/draft/2020-12/schema"


def to_values(study: StudySpec) -> dict[str, Any]:
    """A description as nested dicts and lists, of what TOML and JSON can say.

    Examples
    --------
    >>> from ffdstudio.optimize.spec.parts import BudgetSpec
    >>> msgspec.to_builtins(BudgetSpec(iterations=3))
    {'iterations': 3}
    """
    values = _plain(msgspec.to_builtins(study))
    return {table: value for table, value in values.items() if value}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, tuple | list) else value


def from_values(values: Mapping[str, Any]) -> StudySpec:
    """Inverse of `to_values`.

    Raises
    ------
    InputError
        If the values are not those of a study; the message names table and key.
    """
    tables = [field.name for field in msgspec.structs.fields(StudySpec)]
    for name in values:
        if name not in tables:
            raise InputError(
                f"a case knows no [{name}]{near(str(name), tables)}; it knows {', '.join(tables)}"
            )
    refinement = values.get("refinement")
    return StudySpec(
        shape=part(values.get("shape", {}), ShapeSpec, "shape"),
        lattice=part(values.get("lattice", {}), LatticeSpec, "lattice"),
        variables=part(values.get("variables", {}), VariablesSpec, "variables"),
        objective=row(values.get("objective", {}), OBJECTIVES, "objective"),
        constraints=_constraints(values.get("constraints", [])),
        method=row(values.get("method", {}), METHODS, "method", METHODS[0].kind()),
        refinement=None if refinement is None else part(refinement, RefinementSpec, "refinement"),
        budget=part(values.get("budget", {}), BudgetSpec, "budget"),
    )


def checked(study: StudySpec) -> StudySpec:
    """The same description, its values checked: Python lets anything be put into one.

    Raises
    ------
    InputError
        As `from_values`.
    """
    return from_values(to_values(study))


def _constraints(values: object) -> tuple[ConstraintSpec, ...]:
    if not isinstance(values, list | tuple):
        raise InputError("[[constraints]] takes double brackets, once for each constraint")
    return tuple(row(one, CONSTRAINTS, "constraints") for one in values)


# ---- TOML ----------------------------------------------------------------------------------


def to_toml(study: StudySpec) -> str:
    """Text of a case file."""
    import tomli_w

    return tomli_w.dumps(to_values(study))


def read_study(path: str | os.PathLike[str]) -> StudySpec:
    """Description in a case file.

    Raises
    ------
    InputError
        If the file is no TOML or says something that no study can say.
    """
    name = os.fspath(path)
    values = stricttoml.loads(read_bytes(path), name)
    try:
        return from_values(values)
    except InputError as error:
        raise InputError(f"{name}: {error}") from error


# ---- schema --------------------------------------------------------------------------------


def schema() -> dict[str, Any]:
    """JSON schema of a case file, for editors."""
    made = msgspec.json.schema(StudySpec)
    return {"$schema": SCHEMA, "title": "Case file of FFD Studio", **made}
