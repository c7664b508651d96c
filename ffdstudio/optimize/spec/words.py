"""Words about types: how a message, a form and a page say what a value may be."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

from msgspec import inspect


def sentence_of(docstring: str | None) -> str:
    r"""First paragraph of a docstring in one line.

    Examples
    --------
    >>> sentence_of("Area of a section.\n\nMore.")
    'Area of a section.'
    """
    return " ".join((docstring or "").strip().split("\n\n")[0].split())


def near(word: str, known: Iterable[str]) -> str:
    """Suggestion of a known word that resembles one; empty if none does.

    Examples
    --------
    >>> near("max thickness", ["area", "max-thickness"])
    ' (did you mean max-thickness?)'
    """
    found = difflib.get_close_matches(word, list(known), 1)
    return f" (did you mean {found[0]}?)" if found else ""


def short(value: object) -> str:
    """A value in at most 60 characters."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def may_be(kind: inspect.Type) -> str:
    """What a value of a type is, to end the sentence "... must be".

    Examples
    --------
    >>> may_be(inspect.type_info(tuple[int, int]))
    'a list of 2 values, each a whole number'
    """
    kind, extra = _bare(kind)
    if isinstance(kind, inspect.UnionType):
        return " or ".join(may_be(k) for k in kind.types if not isinstance(k, inspect.NoneType))
    if isinstance(kind, inspect.LiteralType):
        return f"one of {', '.join(map(str, kind.values))}"
    if isinstance(kind, inspect.IntType | inspect.FloatType):
        noun = "a whole number" if isinstance(kind, inspect.IntType) else "a number"
        return noun + _limits(kind.gt, kind.ge, kind.le)
    if isinstance(kind, inspect.VarTupleType | inspect.TupleType):
        return _list_of(kind, bool(extra.get("distinct")))
    return "true or false" if isinstance(kind, inspect.BoolType) else "text"


def _bare(kind: inspect.Type) -> tuple[inspect.Type, dict[str, Any]]:
    """A type without what is said of it, and that."""
    extra: dict[str, Any] = {}
    while isinstance(kind, inspect.Metadata):
        extra |= kind.extra or {}
        kind = kind.type
    return kind, extra


def _limits(above: float | None, least: float | None, most: float | None) -> str:
    if above is not None:
        return f" above {above:g}"
    if least is not None and most is not None:
        return f" from {least:g} to {most:g}"
    return f", at least {least:g}" if least is not None else ""


def _list_of(kind: inspect.VarTupleType | inspect.TupleType, distinct: bool) -> str:
    if isinstance(kind, inspect.TupleType):
        count, item = f"{len(kind.item_types)} ", kind.item_types[0]
    else:
        count, item = _count(kind.min_length, kind.max_length), kind.item_type
    if distinct:
        return f"a list of different words, each {may_be(item)}"
    return f"a list of {count}values, each {may_be(item)}"


def _count(least: int | None, most: int | None) -> str:
    return "" if most is None else f"{least or 0} to {most} "
