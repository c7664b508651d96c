"""Tables of a case file, read with the patience of none: every key is known or refused."""

from __future__ import annotations

import math
from typing import Any

from ffdstudio.errors import InputError

_MISSING = object()
_NAMES = {
    str: "text", int: "a whole number", float: "a number", bool: "true or false", list: "a list",
    dict: "a table",
}  # fmt: skip


class Table:
    """A table whose keys are taken one by one; `finish` refuses what is left.

    Examples
    --------
    >>> table = Table({"columns": 5}, "lattice")
    >>> table.take("columns", int), table.take("rows", int, 2)
    (5, 2)
    >>> table.finish()
    """

    def __init__(self, values: Any, name: str) -> None:
        if not isinstance(values, dict):
            raise InputError(f"[{name}] must be a table")
        self.values, self.name, self.known = dict(values), name, list[str]()

    def take(self, key: str, kind: type, default: Any = _MISSING) -> Any:
        """Value of a key, of the kind asked for.

        Raises
        ------
        InputError
            If it is missing without a default, or of another kind.
        """
        self.known.append(key)
        if key not in self.values:
            if default is _MISSING:
                raise InputError(f"[{self.name}] lacks {key}")
            return default
        value = self.values.pop(key)
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        right = isinstance(value, kind) and (kind is bool or not isinstance(value, bool))
        if not right or (kind is float and not math.isfinite(value)):
            raise InputError(f"[{self.name}] {key} must be {_NAMES[kind]}, got {value!r}")
        return value

    def numbers(self, key: str, default: Any = _MISSING) -> Any:
        """List of finite numbers."""
        values = self.take(key, list, default)
        if values is default:
            return values
        for value in values:
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not math.isfinite(value):
                raise InputError(f"[{self.name}] {key} must be a list of numbers, got {value!r}")
        return [float(value) for value in values]

    def choice(self, key: str, choices: tuple[str, ...], default: Any = _MISSING) -> str:
        """One of several words."""
        value = self.take(key, str, default)
        if value not in choices:
            raise InputError(
                f"[{self.name}] {key} must be one of {', '.join(choices)}, got {value!r}"
            )
        return str(value)

    def finish(self) -> None:
        """Refuse keys that nobody has taken."""
        if self.values:
            raise InputError(
                f"[{self.name}] knows no {', '.join(self.values)}; it knows {', '.join(self.known)}"
            )
