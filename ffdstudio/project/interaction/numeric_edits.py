"""Values that are typed: positions, displacements, weights, turns, for one point or many.

Each is one entry in the history. A coordinate given as None stays as it is for each point.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.project.commands.base import numbers
from ffdstudio.project.document import Document
from ffdstudio.project.edit import Edit
from ffdstudio.project.interaction.transforms import Transform

Coordinates = Sequence[float | None]


def set_position(document: Document, position: Coordinates) -> None:
    """Put all selected points to the given coordinates, in world units."""
    _place(document, lambda edit: _mixed(position, edit.start, 0.0))


def set_displacement(document: Document, vector: Coordinates, absolute: bool = True) -> None:
    """Displace all selected points, from their rest, or from where they are."""
    if absolute:
        _place(document, lambda edit: _mixed(vector, edit.start, _at_rest(edit)))
    else:
        _place(document, lambda edit: _mixed(vector, edit.start, edit.start))


def set_weight(document: Document, weight: float, relative: bool = False) -> None:
    """Give all selected points a weight, or multiply theirs.

    Raises
    ------
    InputError
        If a weight would not be positive and finite.
    """
    edit = document.edit()
    new = edit.weights * weight if relative else np.full(len(edit.points), float(weight))
    _finish(edit, lambda: edit.weigh(new))


def transform(document: Document, change: Transform) -> None:
    """Turn, scale or otherwise map all selected points (see `transforms`)."""
    _place(document, lambda edit: change(edit.start))


def displacement_of(document: Document) -> Array:
    """(k, 3) displacement from rest of the selected points, in ascending order."""
    item = document.model.active_lattice
    if item is None or not document.selection:
        return np.zeros((0, 3))
    where = tuple(np.array(sorted(document.selection)).T)
    return np.asarray(item.current.control_points[where] - item.rest.control_points[where])


def _at_rest(edit: Edit) -> Array:
    return np.array([edit.item.rest.control_points[point] for point in edit.points])


def _mixed(values: Coordinates, start: Array, origin: ArrayLike) -> Array:
    """Start with the given coordinates, counted from `origin`, in place of its own."""
    given = [value is not None for value in values]
    filled = numbers([0.0 if value is None else value for value in values], (3,), "coordinates")
    new: Array = np.where(given, np.asarray(origin) + filled, start)
    return new


def _place(document: Document, where: Callable[[Edit], Array]) -> None:
    edit = document.edit()
    _finish(edit, lambda: edit.place(where(edit)))


def _finish(edit: Edit, change: Callable[[], None]) -> None:
    try:
        change()
    except InputError:
        edit.abort()
        raise
    edit.commit()
