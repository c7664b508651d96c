"""The parts of a lattice as a file holds them: what is missing, unknown or of a wrong kind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ffdstudio.engine.frames import frame_of
from ffdstudio.errors import InputError

NEEDED = ("degrees", "knots", "control_points")
KNOWN = (*NEEDED, "weights", "axes", "periodic", "frame", "reference")


def as_lists(parts: Mapping[str, Any]) -> dict[str, Any]:
    """The parts of a lattice with lists for arrays, as JSON can say them.

    Examples
    --------
    >>> import numpy as np
    >>> as_lists({"knots": [np.array([0.0, 1.0])], "frame": {"origin": (1, 2)}})
    {'knots': [[0.0, 1.0]], 'frame': {'origin': [1, 2]}}
    """
    return {key: _listed(value) for key, value in parts.items()}


def _listed(value: Any) -> Any:
    if isinstance(value, Mapping):
        return as_lists(value)
    if isinstance(value, list | tuple):
        return [_listed(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def checked_parts(parts: Mapping[str, Any], lattice: Any) -> dict[str, Any]:
    """Arguments of the class `lattice` from the parts that a file holds.

    Raises
    ------
    InputError
        If a part is missing, unknown, or of a wrong kind.
    """
    for key in NEEDED:
        if key not in parts:
            raise InputError(f"the {key.replace('_', ' ')} of a lattice are missing")
    for key in parts:
        if key not in KNOWN:
            raise InputError(f"a lattice has no {key!r}")
    arguments = dict(parts)
    lists = [arguments[key] for key in ("degrees", "knots", "periodic") if key in arguments]
    if not all(isinstance(value, list | tuple) for value in lists):
        raise InputError("degrees, knots and what is periodic are lists of a lattice's directions")
    if not all(type(flag) is bool for flag in arguments.get("periodic", ())):
        raise InputError("a direction of a lattice is periodic or not: true or false")
    if ("frame" in arguments) != ("reference" in arguments):
        raise InputError("a lattice in a frame needs its reference, and no other does")
    if "frame" in arguments:
        _add_frame(arguments, lattice)
    return arguments


def _add_frame(arguments: dict[str, Any], lattice: Any) -> None:
    net = arguments["reference"]
    frame = arguments["frame"]
    if not isinstance(frame, Mapping) or not isinstance(net, Mapping):
        raise InputError("frame and reference of a lattice are objects with keys")
    if set(net) != {"control_points", "weights"}:
        raise InputError("the reference of a lattice has control points and weights")
    plain = {key: value for key, value in arguments.items() if key not in ("frame", "reference")}
    arguments["frame"] = frame_of(frame)
    arguments["reference"] = lattice(**{**plain, **net})
