"""Row-wise refinement: each line of control points along one direction has knots of its own.

The lattice holds the knots of all lines; a line's control points are those that its own knots
give it, carried to the common ones by the insertion matrix. So a column may be free in one row
and follow in the others.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice
from ffdstudio.engine.transfer import insertion
from ffdstudio.errors import InputError
from ffdstudio.optimize.variables.rules import Rules


def row_basis(rest: Lattice, rules: Rules, axis: int, own: tuple[Array, ...]) -> Any:
    """Sparse (3 * control points, N) basis of lines with knots of their own."""
    from scipy.sparse import csc_array, hstack

    if rules.fixed or rules.mirror or rules.linked:
        raise InputError("row-wise refinement knows frozen layers, no other rules")
    numbers = np.moveaxis(np.arange(rest.weights.size).reshape(rest.shape), axis, 0)
    numbers = numbers.reshape(rest.shape[axis], -1)
    vectors, blocks = np.array(rules.directions).T, []
    for line in free_lines(rest, rules, axis):
        matrix = own_functions(rest, axis, own[line], rules.layers(rest.dimension)[axis])
        rows = (3 * numbers[:, line][:, None] + np.arange(3)).ravel()
        dense = np.kron(matrix, vectors)
        local, column = np.nonzero(dense)
        shape = (3 * rest.weights.size, dense.shape[1])
        blocks.append(csc_array((dense[local, column], (rows[local], column)), shape))
    return hstack(blocks).tocsc()


def row_carry(
    rest: Lattice, rules: Rules, axis: int, own: tuple[Array, ...], line: int, knot: float
) -> Any:
    """Sparse matrix from old variables to new ones when one line gets one more knot."""
    from scipy.sparse import block_diag, csr_array, identity, kron

    degree, layers = rest.degrees[axis], rules.layers(rest.dimension)[axis]
    blocks = []
    for k in free_lines(rest, rules, axis):
        count = len(own[k]) - degree - 1
        full = insertion(own[k], degree, [knot])[1] if k == line else np.eye(count)
        blocks.append(csr_array(full[layers : len(full) - layers, layers : count - layers]))
    return kron(block_diag(blocks), identity(len(rules.directions))).tocsr()


def own_functions(rest: Lattice, axis: int, own: Array, layers: int) -> Array:
    """(columns, own control points) matrix from a line's own control points to the lattice's."""
    extra = missing(rest.knots[axis], own)
    count = len(own) - rest.degrees[axis] - 1
    matrix = insertion(own, rest.degrees[axis], extra)[1] if extra.size else np.eye(count)
    return matrix[:, layers : count - layers]


def missing(knots: Array, own: Array) -> Array:
    """Knots (with multiplicity) that a line lacks."""
    values, counts = np.unique(knots, return_counts=True)
    have = np.array([(own == value).sum() for value in values])
    return np.repeat(values, np.maximum(counts - have, 0))


def free_lines(rest: Lattice, rules: Rules, axis: int) -> list[int]:
    """Lines outside the frozen layers of the other directions."""
    movable = np.moveaxis(rules.movable(rest.shape), axis, 0)
    return [int(k) for k in np.flatnonzero(movable.reshape(len(movable), -1).any(axis=0))]
