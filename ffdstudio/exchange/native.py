"""Our own lattice file ``*.lattice.json``: versioned, one control point a line, bit for bit.

Python writes the shortest decimal that reads back as the same double, and so do we; the
last index runs fastest.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.containers.strictjson import check_version, field, loads
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.exchange.text import chosen, naming
from ffdstudio.files import write_bytes

NAME, VERSION = "ffdstudio-lattice", 2
_KEYS = ["format", "version", "units", "shape", "degrees", "frame", "frozen_layers", "knots"]
_KEYS += ["rest", "current", "open_faces"]
_KEYS_2 = ["periodic", "coordinates", "reference"]  # since version 2, written where they are needed


def recognises(data: bytes) -> bool:
    """Whether the file says that it is ours."""
    return NAME.encode() in data[:1000]


def read(data: bytes, name: str, block: int | str | None = None) -> LatticeFile:
    """Read our lattice file; raises `InputError` with one sentence on anything unexpected."""
    chosen(("0",), block, name, "lattice")
    values = loads(data, name)
    _check_head(values, name)
    shape = _integers(values, "shape", name)
    degrees = _integers(values, "degrees", name)
    if not 1 <= len(shape) <= 3 or len(degrees) != len(shape):
        raise InputError(f'{name}: "shape" and "degrees" need 1 to 3 numbers each, equally many')
    with naming(name):
        rest, current = (_lattice(values, key, shape, degrees, name) for key in ("rest", "current"))
        frozen = field(values, "frozen_layers", int, name)
        units, faces = field(values, "units", str, name), _faces(values, name)
        return LatticeFile(rest, current, frozen, faces, units=units, format=NAME)


def write(path: Path, content: LatticeFile) -> Exactness:
    """Write our lattice file."""
    write_bytes(path, encode(content))
    return Exactness()


def encode(content: LatticeFile) -> bytes:
    """Return the file's bytes."""
    rest = content.rest
    head: dict[str, Any] = {
        "format": NAME,
        "version": 2 if any(rest.periodic) or rest.frame is not None else 1,
        "units": content.units,
        "shape": list(rest.shape),
        "degrees": list(rest.degrees),
        "frame": rest.axes.tolist(),
        "frozen_layers": content.frozen,
    }
    faces = [list(face) for face in content.open_faces if face not in rest.seams]
    if faces:  # where layers are frozen on all other faces only
        head["open_faces"] = faces
    if any(rest.periodic):
        head["periodic"] = list(rest.periodic)
    if rest.frame is not None:
        head["coordinates"] = rest.frame.parts()
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in head.items()]
    lines += ['  "knots": [', *_rows(u.tolist() for u in rest.knots), "  ],"]
    if rest.reference is not None:
        lines += [*_net("reference", rest.reference), "  },"]
    lines += [*_net("rest", rest), "  },", *_net("current", content.current), "  }"]
    return "\n".join(["{", *lines, "}", ""]).encode()


def _net(key: str, lattice: Lattice) -> list[str]:
    points = lattice.control_points.reshape(-1, 3).tolist()
    weights = lattice.weights.reshape(-1, lattice.shape[-1]).tolist()
    return [
        f'  "{key}": {{',
        '    "control_points": [',
        *_rows(points, "      "),
        "    ],",
        '    "weights": [',
        *_rows(weights, "      "),
        "    ]",
    ]


def _rows(rows: Iterable[list[float]], indent: str = "    ") -> list[str]:
    texts = [indent + json.dumps(row, allow_nan=False) + "," for row in rows]
    return [*texts[:-1], texts[-1][:-1]]


def _check_head(values: dict[str, Any], name: str) -> None:
    if values.get("format") != NAME:
        raise InputError(f'{name}: no lattice file of ours ("format" is not "{NAME}")')
    check_version(values, "version", VERSION, name)
    version = values["version"]
    for key in values:
        if key not in _KEYS and (version < 2 or key not in _KEYS_2):
            raise InputError(f'{name}: the key "{key}" is unknown in version {version}')


def _integers(values: dict[str, Any], key: str, name: str) -> list[int]:
    numbers = field(values, key, list, name)
    if not all(type(n) is int for n in numbers):
        raise InputError(f'{name}: "{key}" must hold whole numbers')
    result: list[int] = numbers
    return result


def _faces(values: dict[str, Any], name: str) -> tuple[tuple[int, ...], ...]:
    faces = field(values, "open_faces", list, name) if "open_faces" in values else []
    if not all(isinstance(face, list) and all(type(n) is int for n in face) for face in faces):
        raise InputError(f'{name}: "open_faces" must hold pairs of whole numbers')
    return tuple(tuple(face) for face in faces)


def _lattice(
    values: dict[str, Any], key: str, shape: list[int], degrees: list[int], name: str
) -> Lattice:
    parts: dict[str, Any] = {
        "degrees": degrees,
        "knots": [_vector(u, f"{name}: knots") for u in field(values, "knots", list, name)],
        **_read_net(values, key, shape, name),
        "axes": _table(values, "frame", (len(shape), 3), name),
    }
    if "periodic" in values:
        parts["periodic"] = field(values, "periodic", list, name)
    if "coordinates" in values:
        parts["frame"] = field(values, "coordinates", dict, name)
        parts["reference"] = _read_net(values, "reference", shape, name)
    return Lattice.of_parts(parts)


def _read_net(
    values: dict[str, Any], key: str, shape: list[int], name: str
) -> dict[str, np.ndarray]:
    net = field(values, key, dict, name)
    count = int(np.prod(shape, dtype=object))
    points = _table(net, "control_points", (count, 3), f"{name}: {key}")
    weights = _table(net, "weights", (count // max(shape[-1], 1), shape[-1]), f"{name}: {key}")
    return {"control_points": points.reshape(*shape, 3), "weights": weights.reshape(shape)}


def _table(values: dict[str, Any], key: str, shape: tuple[int, int], name: str) -> np.ndarray:
    rows = field(values, key, list, name)
    if len(rows) != shape[0]:
        raise InputError(f'{name}: "{key}" must have {shape[0]} rows, got {len(rows)}')
    table = [_vector(row, f'{name}: "{key}" row {i}') for i, row in enumerate(rows)]
    for i, row in enumerate(table):
        if len(row) != shape[1]:
            raise InputError(
                f'{name}: "{key}" row {i} must have {shape[1]} numbers, got {len(row)}'
            )
    return np.array(table, dtype=np.float64)


def _vector(values: object, what: str) -> list[float]:
    if not isinstance(values, list) or not all(type(x) in (int, float) for x in values):
        raise InputError(f"{what}: must be a list of numbers")
    try:
        return [float(x) for x in values]
    except OverflowError:
        raise InputError(f"{what}: holds a number that is too large") from None
