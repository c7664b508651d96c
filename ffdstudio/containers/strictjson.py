"""JSON without the liberties Python takes: no NaN or Infinity, no duplicate keys, one sentence."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from ffdstudio.errors import InputError
from ffdstudio.limits import check_nesting

MAX_CONTAINERS = 2_000_000  # lists and objects in one file: each costs the memory of many letters


def loads(data: bytes, name: str, most: int = MAX_CONTAINERS) -> dict[str, Any]:
    """Return the JSON object in `data`.

    Parameters
    ----------
    data : bytes
        UTF-8, with a byte-order mark or without.
    name : str
        What the file is called in messages.
    most : int
        Lists and objects that it may hold.

    Raises
    ------
    InputError
        If it is no JSON object, one that readers would not agree about, or one without bounds.

    Examples
    --------
    >>> loads(b'{"a": 1.5}', "x.json")
    {'a': 1.5}
    >>> loads(b'{"a": NaN}', "x.json")
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: x.json: NaN is no number in JSON
    """
    if data.count(b"[") + data.count(b"{") > most:
        raise InputError(f"{name}: holds more than {most:,} lists and objects")
    try:
        text = data.decode("utf-8-sig")
        check_nesting(text)
        value = json.loads(
            text,
            parse_constant=_no_constant,
            parse_float=_finite,
            object_pairs_hook=_no_duplicates,
        )
    except UnicodeDecodeError:
        raise InputError(f"{name}: not a text file") from None
    except json.JSONDecodeError as error:
        raise InputError(f"{name}: broken JSON in line {error.lineno}: {error.msg}") from None
    except RecursionError:
        raise InputError(f"{name}: nested too deeply") from None
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    except ValueError:  # an integer of thousands of digits
        raise InputError(f"{name}: holds a number that is too long") from None
    if not isinstance(value, dict):
        raise InputError(f"{name}: must hold one JSON object, not {_kind(value)}")
    return value


def field(data: dict[str, Any], key: str, kind: type | tuple[type, ...], name: str) -> Any:
    """Value of a required key, of the given type, else `InputError`.

    Examples
    --------
    >>> field({"a": "3"}, "a", int, "x.json")
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: x.json: "a" must be a whole number, not a text
    """
    if key not in data:
        raise InputError(f'{name}: "{key}" is missing')
    value = data[key]
    kinds = kind if isinstance(kind, tuple) else (kind,)
    if (isinstance(value, bool) and bool not in kinds) or not isinstance(value, kinds):
        raise InputError(f'{name}: "{key}" must be {_name(kinds[0])}, not {_kind(value)}')
    return value


_NAMES = {
    dict: "an object",
    list: "a list",
    str: "a text",
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    type(None): "null",
}


def _name(kind: type) -> str:
    return _NAMES.get(kind, f"of type {kind.__name__}")


def _kind(value: object) -> str:
    return _name(type(value))


def _no_constant(text: str) -> float:
    raise InputError(f"{text} is no number in JSON")


def _finite(text: str) -> float:
    value = float(text)
    if value in (float("inf"), float("-inf")):
        raise InputError(f"{text} is too large for a number")
    return value


def _no_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise InputError(f'the key "{twice}" occurs twice')
    return result


def check_version(data: dict[str, Any], key: str, newest: int, name: str) -> None:
    """Refuse a file of a version that is not known yet, or never was."""
    version = field(data, key, int, name)
    if version > newest:
        raise InputError(
            f"{name}: written by a newer FFD Studio ({key} {version}, this one reads up to "
            f"{newest}); update FFD Studio to open it"
        )
    if version < 1:
        raise InputError(f"{name}: there is no {key} {version}")


def objects(data: dict[str, Any], key: str, name: str) -> list[dict[str, Any]]:
    """Value of a required key that must be a list of objects, one at least."""
    items = field(data, key, list, name)
    if not items or not all(isinstance(item, dict) for item in items):
        raise InputError(f'{name}: "{key}" must be a list of objects')
    result: list[dict[str, Any]] = items
    return result


def table(rows: Any, name: str) -> np.ndarray:
    """Return a list of equally long lists of numbers as an array (n, m).

    Examples
    --------
    >>> table([[1, 2], [3]], "x.json")
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: x.json: a table needs equally long lists of numbers
    """
    fits = isinstance(rows, list) and rows and all(isinstance(row, list) for row in rows)
    if not fits or len({len(row) for row in rows}) > 1:
        raise InputError(f"{name}: a table needs equally long lists of numbers")
    try:
        if any(type(x) not in (int, float) for row in rows for x in row):
            raise InputError(f"{name}: a table holds something that is no number")
        return np.array(rows, dtype=np.float64)
    except OverflowError:
        raise InputError(f"{name}: holds a number that is too large") from None
