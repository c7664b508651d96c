"""TOML with bounds, and one sentence for whatever is wrong with it."""

from __future__ import annotations

import tomllib
from typing import Any

from ffdstudio.errors import InputError
from ffdstudio.limits import MAX_NESTING, check_nesting


def loads(data: bytes, name: str) -> dict[str, Any]:
    r"""Return the tables in `data`; `name` is what the file is called in messages.

    Raises
    ------
    InputError
        If it is no TOML, is nested too deeply or holds a number without an end.

    Examples
    --------
    >>> loads(b"[shape]\npoints = 61", "x.toml")
    {'shape': {'points': 61}}
    >>> loads(b"a = " + b"[" * 500, "x.toml")
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: x.toml: nested too deeply: 64 levels are the most
    """
    try:
        text = data.decode("utf-8-sig")
        check_nesting(text)
        values = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{name} is no TOML file: {error}") from None
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    except RecursionError:
        raise InputError(f"{name}: nested too deeply") from None
    except ValueError:  # an integer of thousands of digits
        raise InputError(f"{name}: holds a number that is too long") from None
    _check_depth(values, name)
    return values


def _check_depth(values: dict[str, Any], name: str) -> None:
    """Refuse what dotted keys have nested, level by level: no function calls itself here."""
    level: list[Any] = [values]
    for _ in range(MAX_NESTING):
        inner = (item.values() if isinstance(item, dict) else item for item in level)
        level = [item for items in inner for item in items if isinstance(item, dict | list)]
        if not level:
            return
    raise InputError(f"{name}: nested too deeply: {MAX_NESTING} levels are the most")
