"""Tables of a case file: every key is known and its value one that can be, or it is refused.

What a key may be is said once, in `schema`; the sentence of an error is made from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ffdstudio.errors import InputError

REQUIRED: Any = object()


@dataclass(frozen=True)
class Key:
    """What a value may be.

    Attributes
    ----------
    says : str
        Ends the sentence "... must be".
    accepts : callable
        Whether a value of TOML is one.
    default : object
        If the key is absent.
    read : callable
        Makes what the program works with from the value of TOML.
    """

    says: str
    accepts: Callable[[Any], bool]
    default: Any = REQUIRED
    read: Callable[[Any], Any] = lambda value: value

    def __or__(self, default: Any) -> Key:
        """The same with a default."""
        return replace(self, default=default)


class Table:
    """A table of a case file, checked.

    Raises
    ------
    InputError
        If a key is unknown, missing or has a value that cannot be.

    Examples
    --------
    >>> keys = {"columns": whole(least=2), "rows": whole(least=2) | 2}
    >>> Table({"columns": 5}, "lattice", keys)["rows"]
    2
    >>> Table({"columns": 1}, "lattice", keys)
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: [lattice] columns must be a whole number, at least 2, got 1
    """

    def __init__(self, values: Any, name: str, keys: Mapping[str, Key]) -> None:
        if not isinstance(values, dict):
            raise InputError(f"[{name}] must be a table")
        self.name, self.given = name, frozenset(values)
        unknown = [key for key in values if key not in keys]
        if unknown:
            raise InputError(f"[{name}] knows no {', '.join(unknown)}; it knows {', '.join(keys)}")
        self._values = {key: _taken(values, key, rule, name) for key, rule in keys.items()}

    def __getitem__(self, key: str) -> Any:
        return self._values[key]

    def refuse(self, key: str, why: str) -> InputError:
        """Error about a key whose value does not fit the rest of the case."""
        return InputError(f"[{self.name}] {key}: {why}")


def _taken(values: dict[str, Any], key: str, rule: Key, name: str) -> Any:
    if key not in values:
        if rule.default is REQUIRED:
            raise InputError(f"[{name}] lacks {key}")
        return rule.default
    if not rule.accepts(values[key]):
        raise InputError(f"[{name}] {key} must be {rule.says}, got {_short(values[key])}")
    return rule.read(values[key])


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


# ---- kinds of values -----------------------------------------------------------------------


def text() -> Key:
    """Any text but an empty one."""
    return Key("text", lambda value: isinstance(value, str) and value.strip() != "")


def flag() -> Key:
    """True or false."""
    return Key("true or false", lambda value: isinstance(value, bool))


def whole(least: int | None = None, most: int | None = None) -> Key:
    """A whole number within limits."""
    return Key(
        "a whole number" + _limits(least, most),
        lambda v: isinstance(v, int) and not isinstance(v, bool) and _within(v, least, most),
    )


def number(
    least: float | None = None, most: float | None = None, above: float | None = None
) -> Key:
    """A finite number within limits."""
    limits = f" above {above:g}" if above is not None else _limits(least, most)

    def accepts(value: Any) -> bool:
        if not isinstance(value, int | float) or isinstance(value, bool):
            return False
        inside = _within(value, least, most) and (above is None or value > above)
        return math.isfinite(value) and abs(value) < 1e300 and inside

    return Key("a number" + limits, accepts, read=float)


def word(choices: Sequence[str]) -> Key:
    """One of several words."""
    return Key(f"one of {', '.join(choices)}", lambda value: value in tuple(choices))


def several(of: Key, least: int = 1, most: int | None = None, plural: str = "") -> Key:
    """A list of values."""
    count = "" if most is None else f"{most} " if most == least else f"{least} to {most} "
    return Key(
        f"a list of {plural or f'{count}values, each {of.says}'}",
        lambda value: (
            isinstance(value, list)
            and len(value) >= least
            and (most is None or len(value) <= most)
            and all(of.accepts(one) for one in value)
        ),
        read=lambda value: [of.read(one) for one in value],
    )


def words(choices: Sequence[str], least: int = 1) -> Key:
    """A list of different words."""
    rule = several(word(choices), least)
    return replace(
        rule,
        says=f"a list of different words out of {', '.join(choices)}",
        accepts=lambda value: rule.accepts(value) and len(set(value)) == len(value),
    )


def _limits(least: float | None, most: float | None) -> str:
    if least is not None and most is not None:
        return f" from {least:g} to {most:g}"
    return f", at least {least:g}" if least is not None else ""


def _within(value: float, least: float | None, most: float | None) -> bool:
    return (least is None or value >= least) and (most is None or value <= most)
