"""The reference of case files, as Markdown, from the catalog."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import msgspec
from msgspec import inspect

from ffdstudio.optimize.catalog.constraints import CONSTRAINTS
from ffdstudio.optimize.catalog.indicators import INDICATORS
from ffdstudio.optimize.catalog.methods import METHODS
from ffdstudio.optimize.catalog.metrics import METRICS
from ffdstudio.optimize.catalog.objectives import OBJECTIVES
from ffdstudio.optimize.methods.base import MethodSpec
from ffdstudio.optimize.objectives.surface import DeformedSpec
from ffdstudio.optimize.spec.limits import LIMITS, ConstraintSpec
from ffdstudio.optimize.spec.parts import BudgetSpec, LatticeSpec, ShapeSpec, VariablesSpec
from ffdstudio.optimize.spec.refinement import RefinementSpec
from ffdstudio.optimize.spec.rows import Part, Row
from ffdstudio.optimize.spec.words import may_be, sentence_of, short

HEAD = "| key | what it may be | default | meaning |\n|---|---|---|---|"
SHAPES = {"section": "a section", "surface": "a surface in 3D", "any": "any shape"}


def reference() -> str:
    """Every table and key of a case file, with what it may be, its default and its meaning."""
    return "\n\n".join(_blocks()) + "\n"


def _blocks() -> Iterable[str]:
    yield _table("`[shape]`", ShapeSpec)
    yield _table("`[lattice]`", LatticeSpec)
    yield _table("`[variables]`", VariablesSpec)
    yield "### `[objective]`\n\nWhat is made small; `kind` is one of these."
    for kind in OBJECTIVES:
        yield _kind(kind)
    yield f"A table `[objective.deformed]`: {_lower(DeformedSpec.__doc__)}"
    yield _keys(DeformedSpec)
    yield "### `[[constraints]]`\n\nWhat has to be kept: once for each, with these limits."
    yield _keys(ConstraintSpec, only=LIMITS)
    for limit in CONSTRAINTS:
        yield _kind(limit, leave=LIMITS)
    yield "### `[method]`\n\nThese keys, and those of the method."
    yield _keys(MethodSpec)
    yield _list("name", [(kind.kind(), kind.about(), _can(kind)) for kind in METHODS])
    yield _list("metric", [(one.name, one.about(), "") for one in METRICS])
    for method in METHODS:
        own = [f for f in _names(method) if f not in _names(MethodSpec)]
        if own:
            yield f'#### `"{method.kind()}"`'
            yield _keys(method, only=own)
    yield _table("`[refinement]`", RefinementSpec)
    yield _list("indicator", [(one.name, one.about, "") for one in INDICATORS])
    yield _table("`[budget]`", BudgetSpec)


def _table(title: str, kind: type[Part]) -> str:
    return f"### {title}\n\n{sentence_of(kind.__doc__)}\n\n{_keys(kind)}"


def _kind(kind: type[Row], leave: Iterable[str] = ()) -> str:
    keys = [name for name in _names(kind) if name not in leave]
    head = f'#### `"{kind.kind()}"`: {kind.title}\n\n{kind.about()} For {SHAPES[kind.needs]}.'
    return f"{head}\n\n{_keys(kind, only=keys)}" if keys else head


def _can(kind: type[MethodSpec]) -> str:
    parts = ["keeps constraints"] * kind.constraints + ["needs residuals"] * kind.residuals
    return ", ".join(parts)


def _list(key: str, rows: list[tuple[str, str, str]]) -> str:
    lines = [f"| {key} | what it is | |\n|---|---|---|"]
    return "\n".join(
        [*lines, *(f'| `"{name}"` | {about} | {more} |' for name, about, more in rows)]
    )


def _keys(kind: type[Part], only: Iterable[str] | None = None) -> str:
    fields = msgspec.structs.fields(kind)
    wanted = [f for f in fields if only is None or f.name in only]
    return "\n".join([HEAD, *(_line(field) for field in wanted)])


def _line(field: msgspec.structs.FieldInfo) -> str:
    info = inspect.type_info(field.type)
    said, extra = _said(info)
    unit = f" ({extra['unit']})" if extra.get("unit") else ""
    words = (f"`{field.name}`", _may_be(info) + unit, _default(field), said.get("description", ""))
    return f"| {' | '.join(word.replace('|', '&#124;') for word in words)} |"


def _may_be(info: inspect.Type) -> str:
    bare: Any = info
    while isinstance(bare, inspect.Metadata):
        bare = bare.type
    parts = bare.types if isinstance(bare, inspect.UnionType) else (bare,)
    return "a table" if any(isinstance(p, inspect.StructType) for p in parts) else may_be(info)


def _default(field: msgspec.structs.FieldInfo) -> str:
    if field.required:
        return "has to be given"
    if field.default is None:
        return "none"
    shown = list(field.default) if isinstance(field.default, tuple) else field.default
    text = {True: "true", False: "false"}.get(shown) if isinstance(shown, bool) else None
    return f"`{text or short(shown)}`"


def _said(info: inspect.Type) -> tuple[dict[str, str], dict[str, str]]:
    if isinstance(info, inspect.Metadata):
        return info.extra_json_schema or {}, info.extra or {}
    return {}, {}


def _names(kind: type[Part]) -> list[str]:
    return [field.name for field in msgspec.structs.fields(kind)]


def _lower(text: str | None) -> str:
    sentence = sentence_of(text)
    return sentence[:1].lower() + sentence[1:]
