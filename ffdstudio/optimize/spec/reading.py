"""Descriptions from plain values (of TOML, of JSON), with messages that name table and key.

1. A table is read field by field, so that whatever is wrong is told of its own key; nothing is
   learned from the text of another library's error.
2. Numbers are finite: neither JSON nor a lattice has a use for others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import msgspec

from ffdstudio.errors import InputError
from ffdstudio.optimize.spec.fields import DISTINCT
from ffdstudio.optimize.spec.rows import Part, Row
from ffdstudio.optimize.spec.words import may_be, near, short

P = TypeVar("P", bound=Part)
R = TypeVar("R", bound=Row)
HUGE = 1e300


def part(values: object, kind: type[P], table: str) -> P:
    """A table of a description.

    Parameters
    ----------
    values : object
        What the file holds in its place.
    kind : type
        Of the table.
    table : str
        Its name in messages.

    Raises
    ------
    InputError
        If a key is unknown, missing or has a value that cannot be.
    """
    if not isinstance(values, Mapping):
        raise InputError(f"[{table}] must be a table")
    fields = {f.name: f for f in msgspec.structs.fields(kind)}
    for key in values:
        if key not in fields:
            hint = near(str(key), fields)
            raise InputError(f"[{table}] knows no {key}{hint}; it knows {', '.join(fields)}")
    given = {name: _value(values, f, table) for name, f in fields.items() if _given(values, f)}
    missing = [name for name, f in fields.items() if f.required and name not in given]
    if missing:
        raise InputError(f"[{table}] lacks {missing[0]}")
    return _made(kind, given, table)


def _made(kind: type[P], given: dict[str, Any], table: str) -> P:
    try:
        return kind(**given)
    except ValueError as error:  # of the description's own checks
        raise InputError(f"[{table}] {error}") from None


def _given(values: Mapping[str, Any], field: msgspec.structs.FieldInfo) -> bool:
    return field.name in values and not (values[field.name] is None and field.default is None)


def _value(values: Mapping[str, Any], field: msgspec.structs.FieldInfo, table: str) -> Any:
    value, nested = values[field.name], part_of(field.type)
    if nested is not None:
        return part(value, nested, f"{table}.{field.name}")
    kind = msgspec.inspect.type_info(field.type)
    try:
        taken = msgspec.convert(value, field.type, strict=True)
        fits = _finite(taken) and _different(taken, kind)
    except msgspec.ValidationError:
        fits = False
    if not fits:
        raise InputError(f"[{table}] {field.name} must be {may_be(kind)}, got {short(value)}")
    return taken


def part_of(annotation: Any) -> type[Part] | None:
    """The table that a field holds, if it holds one."""
    for choice in (annotation, *getattr(annotation, "__args__", ())):
        if isinstance(choice, type) and issubclass(choice, Part):
            return choice
    return None


def _finite(value: object) -> bool:
    if isinstance(value, tuple):
        return all(map(_finite, value))
    return not isinstance(value, float) or (math.isfinite(value) and abs(value) < HUGE)


def _different(value: object, kind: msgspec.inspect.Type) -> bool:
    """Whether a list has no value twice, if its type asks for that."""
    if not isinstance(value, tuple) or not _asks_different(kind):
        return True
    return len(set(value)) == len(value)


def _asks_different(kind: msgspec.inspect.Type) -> bool:
    if isinstance(kind, msgspec.inspect.UnionType):
        return any(map(_asks_different, kind.types))
    if isinstance(kind, msgspec.inspect.Metadata):
        return bool((kind.extra or {}).get(DISTINCT)) or _asks_different(kind.type)
    return False


def row(values: object, kinds: Sequence[type[R]], table: str, usual: str | None = None) -> R:
    """A table whose kind is one of several, by its tag.

    Parameters
    ----------
    usual : str, optional
        The kind if none is given.
    """
    tag = str(kinds[0].__struct_config__.tag_field)
    if not isinstance(values, Mapping):
        raise InputError(f"[{table}] must be a table")
    word = values.get(tag, usual)
    if word is None:
        raise InputError(f"[{table}] lacks {tag}: one of {', '.join(k.kind() for k in kinds)}")
    found = [kind for kind in kinds if kind.kind() == word]
    if not found:
        words = [kind.kind() for kind in kinds]
        raise InputError(
            f"[{table}] {tag} must be one of {', '.join(words)}, got {short(word)}"
            f"{near(str(word), words)}"
        )
    rest = {key: value for key, value in values.items() if key != tag}
    return part(rest, found[0], table)
