"""Splines of splinepy in its JSON form; control points u fastest."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.containers.strictjson import field, loads, objects, table
from ffdstudio.engine import Lattice
from ffdstudio.engine.knots import clamped_uniform
from ffdstudio.errors import InputError
from ffdstudio.exchange.conversion import ConversionRules, adapted
from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.exchange.nets import from_rows, own_axes, to_rows
from ffdstudio.exchange.text import chosen, naming
from ffdstudio.files import write_bytes

RULES = ConversionRules("splinepy JSON", dimensions=(1, 2, 3))


def recognises(data: bytes) -> bool:
    """Whether it has splinepy's keys."""
    return b'"SplineList"' in data


def read(data: bytes, name: str, block: int | str | None = None) -> LatticeFile:
    """Read one spline of the file; without knot vectors it is a Bezier spline."""
    values = loads(data, name)
    if values.get("Base64Encoding"):
        raise InputError(f"{name}: base64 control points are not read; save without the encoding")
    splines = objects(values, "SplineList", name)
    names = tuple(str(k) for k in range(len(splines)))
    spline = splines[chosen(names, block, name, "spline")]
    with naming(name):
        lattice = _lattice(spline, name)
    return LatticeFile(lattice, lattice, format="splinepy", blocks=names)


def write(path: Path, content: LatticeFile, adapt: str = "refuse") -> Exactness:
    """Write one spline."""
    fitting, exactness = adapted(content, RULES, adapt)
    lattice = fitting.current
    spline = {
        "degrees": list(lattice.degrees),
        "control_points": to_rows(lattice.control_points).tolist(),
        "knot_vectors": [u.tolist() for u in lattice.knots],
        "weights": to_rows(lattice.weights[..., None]).tolist(),
        "SplineType": "NURBS",
        "dim": 3,
        "para_dim": lattice.dimension,
        "show_options": {},
    }
    group = {"Name": "SplineGroup", "NumberOfSplines": 1, "Base64Encoding": False}
    text = json.dumps({**group, "SplineList": [spline]}, indent=1)
    write_bytes(path, (text + "\n").encode())
    return exactness


def _lattice(spline: dict[str, Any], name: str) -> Lattice:
    degrees = field(spline, "degrees", list, name)
    if not 1 <= len(degrees) <= 3 or not all(type(p) is int and p > 0 for p in degrees):
        raise InputError(f'{name}: "degrees" needs 1 to 3 whole numbers of at least 1')
    if "knot_vectors" in spline:
        given = field(spline, "knot_vectors", list, name)
        knots = [np.ravel(table([u], name)) for u in given]
    else:
        knots = [clamped_uniform(p + 1, p) for p in degrees]
    shape = [len(u) - p - 1 for u, p in zip(knots, degrees, strict=False)]
    points = table(field(spline, "control_points", list, name), name)
    count = int(np.prod(shape, dtype=object)) if shape else 0
    weights = np.ravel(table(spline.get("weights") or [[1.0]] * len(points), name))
    fits = len(knots) == len(degrees) and min(shape) > 1 and len(points) == len(weights) == count
    if not fits or points.shape[1] not in (2, 3):
        raise InputError(f"{name}: degrees, knots, control points and weights do not fit together")
    net = np.zeros((*shape, 3))
    net[..., : points.shape[1]] = from_rows(points, shape)
    return Lattice(degrees, knots, net, from_rows(weights[:, None], shape)[..., 0], own_axes(net))
