"""Nested values with arrays and lattices in them, as JSON plus ``.npy`` entries.

An array becomes ``{"$array": "arrays/3.npy"}`` and a lattice ``{"$lattice": {...}}`` with
arrays inside, so every float keeps its bits and nothing is ever pickled.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from ffdstudio.containers import npy
from ffdstudio.containers.strictjson import field
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError

ARRAY, LATTICE = "$array", "$lattice"


def encode(value: Any, entries: dict[str, bytes]) -> Any:
    """Return what JSON can say of `value`; arrays are added to `entries`.

    Tuples come back as lists.

    Raises
    ------
    TypeError
        If there is something in it that a project cannot hold.
    """
    if isinstance(value, np.ndarray):
        return {ARRAY: _add_array(value, entries)}
    if isinstance(value, np.generic):
        return encode(value.item(), entries)
    if isinstance(value, Lattice):
        return {LATTICE: encode(_lattice_parts(value), entries)}
    if isinstance(value, Mapping):
        return {_key(key): encode(item, entries) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [encode(item, entries) for item in value]
    if isinstance(value, float) and not np.isfinite(value):  # JSON has no word for these
        return encode(np.array(value), entries)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a project cannot hold a {type(value).__name__}")


def decode(value: Any, entries: Mapping[str, bytes], name: str) -> Any:
    """Inverse of `encode`; raises `InputError` naming the file `name`."""
    if isinstance(value, list):
        return [decode(item, entries, name) for item in value]
    if not isinstance(value, dict):
        return value
    if value.keys() == {ARRAY}:
        return _read_array(field(value, ARRAY, str, name), entries, name)
    parts = {key: decode(item, entries, name) for key, item in value.items() if key != LATTICE}
    if value.keys() == {LATTICE}:
        return _read_lattice(decode(field(value, LATTICE, dict, name), entries, name), name)
    return parts


def _key(key: object) -> str:
    if not isinstance(key, str) or key.startswith("$"):
        raise TypeError(f"a project cannot hold the key {key!r}")
    return key


def _lattice_parts(lattice: Lattice) -> dict[str, Any]:
    return lattice.parts()


def _read_lattice(parts: dict[str, Any], name: str) -> Lattice:
    degrees, knots = field(parts, "degrees", list, name), field(parts, "knots", list, name)
    for key in ("control_points", "weights", "axes"):
        field(parts, key, np.ndarray, name)
    whole = all(type(degree) is int for degree in degrees)
    if not whole or not all(isinstance(u, np.ndarray) for u in knots):
        raise InputError(f"{name}: a lattice in it has no proper degrees or knots")
    try:
        return Lattice.of_parts(parts)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _add_array(array: np.ndarray, entries: dict[str, bytes]) -> str:
    if array.dtype.kind not in "biuf":
        raise TypeError(f"a project cannot hold an array of {array.dtype}")
    name = f"arrays/{sum(entry.startswith('arrays/') for entry in entries)}.npy"
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=False)
    entries[name] = stream.getvalue()
    return name


def _read_array(entry: str, entries: Mapping[str, bytes], name: str) -> Any:
    if entry not in entries:
        raise InputError(f"{name}: the array {entry} is missing")
    try:
        array = npy.loads(entries[entry])
    except ValueError:
        raise InputError(f"{name}: the array {entry} is damaged") from None
    return array if array.ndim else array.item()
