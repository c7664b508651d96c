"""A command as one line of JSON, and back: what the journal is written in.

Every float comes back with its bits (Python writes the shortest decimal that does), every
value is checked against the type of its field, and nothing else is accepted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, Field, fields
from typing import Any

from ffdstudio.engine import Lattice
from ffdstudio.engine.parts import as_lists
from ffdstudio.errors import InputError
from ffdstudio.optimize.spec.codec import from_values, to_values
from ffdstudio.optimize.spec.study import StudySpec
from ffdstudio.project.commands import COMMANDS, Command, CreateBox

NOT_SAID = ("mesh", "packed")  # what a path and a hash stand for


def to_words(command: Command) -> dict[str, Any]:
    """Return a command as what JSON can say; fields at their default are left out.

    Examples
    --------
    >>> from ffdstudio.project.commands import Rename
    >>> to_words(Rename("body1", "wing"))
    {'do': 'rename', 'item': 'body1', 'name': 'wing'}
    """
    return {"do": command.verb, **_fields_out(command)}


def to_command(words: dict[str, Any]) -> Command:
    """Inverse of `to_words`.

    Raises
    ------
    InputError
        If it is no command, or a field is missing, unknown or of the wrong type.

    Examples
    --------
    >>> to_command({"do": "rename", "item": "body1", "name": "wing"})
    Rename(item='body1', name='wing')
    """
    verb = words.get("do")
    if not isinstance(verb, str) or verb not in COMMANDS:
        raise InputError(f"{verb!r} is no command")
    rest = {key: value for key, value in words.items() if key != "do"}
    result: Command = _fields_in(COMMANDS[verb], rest, verb)
    return result


def _said(command: type[Command] | Command) -> list[Field[Any]]:
    return [f for f in fields(command) if f.name not in NOT_SAID]


def _fields_out(command: Command) -> dict[str, Any]:
    values = {f.name: (getattr(command, f.name), f.default) for f in _said(command)}
    return {name: _out(value) for name, (value, usual) in values.items() if value is not usual}


def _fields_in(kind: type[Command], words: dict[str, Any], verb: str) -> Any:
    known = {f.name: f for f in _said(kind)}
    for name in words:
        if name not in known:
            raise InputError(f'"{verb}" has no "{name}"')
    for name, f in known.items():
        if name not in words and f.default is MISSING:
            raise InputError(f'"{verb}" needs "{name}"')
    read = {name: _in(value, str(known[name].type), name) for name, value in words.items()}
    return kind(**read)


def _out(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_out(item) for item in value]
    if isinstance(value, Lattice):
        return lattice_out(value)
    if isinstance(value, StudySpec):
        return to_values(value)
    return _fields_out(value) if isinstance(value, Command) else value


def _in(value: Any, kind: str, name: str) -> Any:
    for choice in kind.split(" | "):
        try:
            return READERS[choice](value)
        except (TypeError, ValueError, KeyError) as error:
            if isinstance(error, InputError):
                raise
    raise InputError(f'"{name}" has a value that does not fit')


# ---- types -------------------------------------------------------------------------------


def _exact(*kinds: type) -> Callable[[Any], Any]:
    def read(value: Any) -> Any:
        if type(value) not in kinds:
            raise TypeError
        return value

    return read


def _float(value: Any) -> float:
    return float(_exact(int, float)(value))


def _each(read: Callable[[Any], Any]) -> Callable[[Any], tuple[Any, ...]]:
    return lambda value: tuple(read(item) for item in _exact(list)(value))


def _pair(read: Callable[[Any], Any]) -> Callable[[Any], tuple[str, Any]]:
    def both(value: Any) -> tuple[str, Any]:
        name, item = _exact(list)(value)
        return _exact(str)(name), read(item)

    return both


def lattice_out(lattice: Lattice) -> dict[str, Any]:
    """Return a lattice as what JSON can say."""
    return as_lists(lattice.parts())


def _lattice(value: Any) -> Lattice:
    parts = _exact(dict)(value)
    _each(_exact(int))(parts["degrees"])
    return Lattice.of_parts(parts)


READERS: dict[str, Callable[[Any], Any]] = {
    "str": _exact(str),
    "int": _exact(int),
    "bool": _exact(bool),
    "float": _float,
    "None": _exact(type(None)),
    "Index": _each(_exact(int)),
    "Numbers": _each(_float),
    "Points": _each(_each(_float)),
    "Lattice": _lattice,
    "StudySpec": lambda value: from_values(_exact(dict)(value)),
    "CreateBox": lambda value: _fields_in(CreateBox, _exact(dict)(value), "box"),
    "tuple[str, ...]": _each(_exact(str)),
    "tuple[Index, ...]": _each(_each(_exact(int))),
    "tuple[tuple[str, float], ...]": _each(_pair(_float)),
    "tuple[tuple[str, Lattice], ...]": _each(_pair(_lattice)),
}
"""How to read a value, by the type that a command's field declares."""
