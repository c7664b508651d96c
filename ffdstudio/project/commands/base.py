"""What every command is, and what several of them need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.project.model import Index, LatticeItem, Model

Numbers = tuple[float, ...]
Points = tuple[Numbers, ...]


@dataclass(frozen=True)
class Command:
    """Base of all commands; `verb` is its word in the journal.

    `looks_only` says that no point moves by it: it hides, shows, colours, names, or chooses how a
    file is written.
    """

    verb: ClassVar[str]
    looks_only: ClassVar[bool] = False

    def apply(self, model: Model) -> Model:
        """Return the model after the command; `InputError` if it makes no sense there."""
        raise NotImplementedError

    def label(self, model: Model) -> str:
        """Short text for the history, given the model before the command."""
        raise NotImplementedError


def where(
    item: LatticeItem, points: tuple[Index, ...], frozen_too: bool = False
) -> tuple[np.ndarray, ...]:
    """Return index arrays of control points, checked."""
    shape = item.rest.shape
    if any(len(point) != len(shape) for point in points):
        raise InputError(f"a control point of {item.name} has {len(shape)} indices")
    rows = np.array(points if len(points) else np.zeros((0, len(shape)), dtype=int))
    if rows.shape != (len(points), len(shape)) or rows.dtype.kind != "i":
        raise InputError(f"a control point of {item.name} has {len(shape)} indices")
    if ((rows < 0) | (rows >= np.array(shape))).any():
        raise InputError(
            f"{item.name} has {'x'.join(map(str, shape))} control points; "
            "one of those to edit is outside"
        )
    if not frozen_too and item.frozen and item.frozen_mask[tuple(rows.T)].any():
        raise InputError(f"a control point to edit lies in the frozen layers of {item.name}")
    return tuple(rows.T)


def numbers(values: Any, shape: tuple[int, ...], what: str) -> np.ndarray:
    """Return values as an array of that shape; `InputError` if they are none."""
    try:
        array = np.array(values, dtype=np.float64).reshape(shape)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be {shape} numbers") from None
    return array


def reset(item: LatticeItem, mask: np.ndarray) -> Lattice:
    """Return the current lattice with the points of the mask back at rest."""
    points = np.where(mask[..., None], item.rest.control_points, item.current.control_points)
    weights = np.where(mask, item.rest.weights, item.current.weights)
    new = item.rest.moved(points, weights)
    return item.rest if new == item.rest else new


def refined(model: Model, key: str, refine: Callable[[Lattice], Lattice]) -> Model:
    """Model with one lattice refined in all its states."""
    item = model.lattice(key)
    rest = refine(item.rest)
    current = refine(item.current) if item.deformed else rest
    shapes = {name: refine(shape) for name, shape in item.shapes.items()}
    return model.with_(replace(item, rest=rest, current=current, shapes=shapes, coarser=item.rest))


def named(points: tuple[Index, ...]) -> str:
    """Return how a label speaks of control points."""
    if len(points) == 1:
        return f"point ({', '.join(map(str, points[0]))})"
    return f"{len(points)} points"
