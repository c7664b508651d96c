"""Volumes of geomdl (NURBS-Python) in its JSON form; point index v + size_v (u + size_u w)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ffdstudio.containers.strictjson import field, loads, objects, table
from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.exchange.conversion import ConversionRules, adapted
from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.exchange.text import chosen, naming
from ffdstudio.files import write_bytes

RULES = ConversionRules("geomdl JSON")


def recognises(data: bytes) -> bool:
    """Whether it has geomdl's keys."""
    return b'"shape"' in data[:1000] and b'"knotvector_u"' in data


def read(data: bytes, name: str, block: int | str | None = None) -> LatticeFile:
    """Read one volume of the file."""
    shape = field(loads(data, name), "shape", dict, name)
    if field(shape, "type", str, name) != "volume":
        raise InputError(f"{name}: only volumes of geomdl are lattices, this is a {shape['type']}")
    volumes = objects(shape, "data", name)
    names = tuple(str(k) for k in range(len(volumes)))
    volume = volumes[chosen(names, block, name, "volume")]
    with naming(name):
        lattice = _lattice(volume, name)
    return LatticeFile(lattice, lattice, format="geomdl", blocks=names)


def write(path: Path, content: LatticeFile, adapt: str = "refuse") -> Exactness:
    """Write one volume."""
    fitting, exactness = adapted(content, RULES, adapt)
    lattice = fitting.current
    volume: dict[str, Any] = {"type": "spline", "rational": True, "dimension": 3}
    for key, values in (
        ("degree", lattice.degrees),
        ("knotvector", [u.tolist() for u in lattice.knots]),
        ("size", lattice.shape),
    ):
        volume |= {f"{key}_{d}": value for d, value in zip("uvw", values, strict=True)}
    order = (2, 0, 1)  # w slowest, v fastest
    points = lattice.control_points.transpose(*order, 3).reshape(-1, 3).tolist()
    weights = lattice.weights.transpose(order).ravel().tolist()
    volume["control_points"] = {"points": points, "weights": weights}
    shape = {"type": "volume", "count": 1, "data": [volume]}
    write_bytes(path, (json.dumps({"shape": shape}, indent=1) + "\n").encode())
    return exactness


def _lattice(volume: dict[str, Any], name: str) -> Lattice:
    degrees = [field(volume, f"degree_{d}", int, name) for d in "uvw"]
    sizes = [field(volume, f"size_{d}", int, name) for d in "uvw"]
    knots = [np.ravel(table([field(volume, f"knotvector_{d}", list, name)], name)) for d in "uvw"]
    net = field(volume, "control_points", dict, name)
    points = table(field(net, "points", list, name), name)
    weights = np.ravel(table([net.get("weights") or [1.0] * len(points)], name))
    count = sizes[0] * sizes[1] * sizes[2]
    if min(sizes) < 2 or points.shape != (count, 3) or weights.shape != (count,):
        raise InputError(f"{name}: sizes {sizes} need {count} points of 3 numbers and weights")
    u, v, w = sizes
    return Lattice(
        degrees,
        knots,
        points.reshape(w, u, v, 3).transpose(1, 2, 0, 3),
        weights.reshape(w, u, v).transpose(1, 2, 0),
    )
