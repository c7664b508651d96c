"""Lattices brought into the space of others: knots are inserted, the shape stays."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine.lattice import Lattice
from ffdstudio.errors import InputError


def in_space_of(lattice: Lattice, finer: Lattice) -> Lattice:
    """Return a lattice with knots inserted until it is in the space of a finer one.

    Parameters
    ----------
    lattice, finer : Lattice

    Returns
    -------
    Lattice
        The same object if there is nothing to insert.

    Raises
    ------
    InputError
        If that one is no refinement of it.

    Examples
    --------
    >>> coarse = Lattice.box([0], [1], shape=(4,))
    >>> in_space_of(coarse, coarse.insert_knots(0, [0.5])).shape
    (5,)
    """
    refined = with_knots_of(lattice, finer)
    if not refined.same_space(finer):
        raise InputError("the iterate belongs to a lattice of other knots or degrees")
    return refined


def with_knots_of(lattice: Lattice, other: Lattice) -> Lattice:
    """Return a lattice with those knots of another one inserted that it does not have.

    Lattices of other degrees or ranges have no knots in common; nothing is inserted then.
    """
    if lattice.degrees != other.degrees or not np.array_equal(lattice.domain, other.domain):
        return lattice
    for axis in range(lattice.dimension):
        missing = _missing(lattice.knots[axis], other.knots[axis])
        lattice = lattice.insert_knots(axis, missing) if len(missing) else lattice
    return lattice


def _missing(coarse: Array, fine: Array) -> Array:
    values, counts = np.unique(fine, return_counts=True)
    have = np.array([(coarse == value).sum() for value in values])
    return np.repeat(values, np.maximum(counts - have, 0))
