"""The design space: a lattice, and the displacements of its control points by variables.

1. Variables y move the control points by basis @ y around the lattice at y = 0, and a
   refinement makes the lattice that was reached the new origin: it is the same shape.
2. A refined space must contain the old one, or the cost could rise. If the basis that the
   rules give does, it is taken: its variables are control points. Otherwise the old basis is
   carried over, and the functions that the new knot brings are added to it: row-wise
   refinement, and control points fixed one by one.
3. With weights the homogeneous control points are inserted, so displacements carry over by
   diag(1/w') A diag(w).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array, Mask
from ffdstudio.engine import Lattice
from ffdstudio.engine.transfer import insertion
from ffdstudio.errors import InputError
from ffdstudio.optimize.variables.rows import row_basis, row_carry
from ffdstudio.optimize.variables.rules import Rules

SAME = 1e-9  # of the range: knots as near to each other are one


@dataclass(frozen=True)
class Insertion:
    """A knot to insert in one direction; `line` names one line of control points, if not all.

    A line is the flat index over the other directions: the row of a 2D lattice.
    """

    axis: int
    knot: float
    line: int | None = None


@dataclass(frozen=True, eq=False)
class DesignSpace:
    """Variables around a lattice; made by `DesignSpace.of`.

    Attributes
    ----------
    rest : Lattice
        The lattice at rest, refined as the other one is.
    lattice : Lattice
        The lattice at y = 0.
    fixed : numpy.ndarray
        Mask of control points that stay by name.
    basis : scipy.sparse array
        (3 * control points, N).
    by_rules : bool
        Whether the basis is the rules' own, so that variables are control points.
    own : tuple of numpy.ndarray, optional
        Knots of each line of control points, once the refinement is row-wise.
    """

    rest: Lattice
    lattice: Lattice
    rules: Rules
    fixed: Mask
    basis: Any = field(repr=False)
    by_rules: bool = True
    own: tuple[Array, ...] | None = None

    @classmethod
    def of(cls, rest: Lattice, rules: Rules, current: Lattice | None = None) -> Self:
        """Design space of a lattice.

        Raises
        ------
        InputError
            If the rules do not fit the lattice or leave nothing to move.

        Examples
        --------
        >>> box = Lattice.box([0, 0, 0], [1, 1, 0], shape=(5, 2))
        >>> space = DesignSpace.of(box, Rules())
        >>> space.size, space.refined(Insertion(0, 0.25))[0].size
        (10, 12)
        """
        fixed = rules.held(rest.shape)
        basis = rules.basis(rules.movable(rest.shape) & ~fixed)
        if basis.shape[1] == 0:
            raise InputError("the rules leave no control point to move")
        return cls(rest, current if current is not None else rest, rules, fixed, basis)

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.basis.shape[1])

    @property
    def displacements(self) -> Array:
        """(control points, 3) how far the control points are from rest at y = 0."""
        return (self.lattice.control_points - self.rest.control_points).reshape(-1, 3)

    def at(self, y: ArrayLike) -> Lattice:
        """Lattice at variables y."""
        step = (self.basis @ np.asarray(y, dtype=np.float64)).reshape(*self.lattice.shape, 3)
        return self.lattice.moved(self.lattice.control_points + step)

    def around(self, y: ArrayLike) -> Self:
        """The same space with y as its origin."""
        return replace(self, lattice=self.at(y))

    def refined(self, new: Insertion) -> tuple[Self, Any]:
        """Space with a knot inserted, and the matrix that carries variables into it.

        Raises
        ------
        InputError
            If the rules allow no refinement in that direction.
        """
        if self.rest.periodic[new.axis]:
            raise InputError(f"direction {'ijk'[new.axis]} is periodic: studies do not refine it")
        new = replace(new, knot=joined(self.rest.knots[new.axis], new.knot))
        if not self.rules.refinable(new.axis):
            raise InputError(f"direction {'ijk'[new.axis]} is mirrored or linked, not to refine")
        return self._with_column(new) if new.line is None else self._with_row(new, new.line)

    def _with_column(self, new: Insertion) -> tuple[Self, Any]:
        rest = self.rest.insert_knots(new.axis, [new.knot])
        current = self.lattice.insert_knots(new.axis, [new.knot])
        matrix = insertion(self.rest.knots[new.axis], self.rest.degrees[new.axis], [new.knot])[1]
        reached = np.tensordot(matrix != 0, self.fixed, axes=(1, new.axis)).astype(bool)
        fixed = np.moveaxis(reached, 0, new.axis)
        old = (self._carry(matrix, new.axis, current) @ self.basis).tocsc()
        movable = self.rules.movable(rest.shape) & ~fixed
        basis, carry, by_rules = self._grown(old, movable, new)
        changed = {"rest": rest, "lattice": current, "fixed": fixed, "basis": basis}
        return replace(self, **changed, by_rules=by_rules), carry

    def _with_row(self, new: Insertion, line: int) -> tuple[Self, Any]:
        rest, current, axis = self.rest, self.lattice, new.axis
        own = self.own or (rest.knots[axis],) * (rest.weights.size // rest.shape[axis])
        carry = row_carry(rest, self.rules, axis, own, line, new.knot)
        if self.own is None:  # so far the variables stand in another order
            carry = carry @ _coordinates(row_basis(rest, self.rules, axis, own), self.basis)
        own = tuple(np.sort(np.append(u, new.knot)) if k == line else u for k, u in enumerate(own))
        if not (rest.knots[axis] == new.knot).any():
            rest = rest.insert_knots(axis, [new.knot])
            current = current.insert_knots(axis, [new.knot])
        basis = row_basis(rest, self.rules, axis, own)
        changed = {"rest": rest, "lattice": current, "basis": basis, "own": own}
        fixed = np.zeros(rest.shape, dtype=bool)
        return replace(self, **changed, fixed=fixed, by_rules=False), carry

    def _carry(self, matrix: Array, axis: int, finer: Lattice) -> Any:
        """Sparse matrix from displacements of control points to those of the finer lattice."""
        from scipy.sparse import csr_array, diags_array, identity, kron

        shape = self.rest.shape
        before, after = np.prod(shape[:axis], dtype=int), np.prod(shape[axis + 1 :], dtype=int)
        full = kron(kron(identity(before), csr_array(matrix)), identity(after))
        weighted = (
            diags_array(1 / finer.weights.ravel())
            @ full
            @ diags_array(self.lattice.weights.ravel())
        )
        return csr_array(kron(weighted, identity(3)))

    def _grown(self, old: Any, movable: Mask, new: Insertion) -> tuple[Any, Any, bool]:
        """Basis of the finer space, how variables carry over, and whether it is the rules' own."""
        from scipy.sparse import csr_array, hstack, identity, vstack

        if self.by_rules:
            basis = self.rules.basis(movable)
            carry = _coordinates(basis, old)
            if abs(basis @ carry - old).max() <= 1e-12 * abs(old).max():
                return basis, carry, True
        knots, degree = self.rest.knots[new.axis], self.rest.degrees[new.axis]
        index = new_function(knots, degree, new.knot, self.rules.layers(movable.ndim)[new.axis])
        slab = np.zeros(movable.shape, dtype=bool)
        np.moveaxis(slab, new.axis, 0)[index] = True
        added = self.rules.basis(movable & slab)
        carry = vstack([identity(self.size), csr_array((added.shape[1], self.size))])
        return hstack([old, added]).tocsc(), csr_array(carry), False


def joined(knots: Array, knot: float) -> float:
    """The knot that is there already if a new one differs from it by rounding.

    Examples
    --------
    >>> joined(np.array([0.0, 0.84, 1.0]), 0.8400000000000001)
    0.84
    """
    nearest = float(knots[np.argmin(np.abs(knots - knot))])
    return nearest if abs(nearest - knot) <= SAME * np.ptp(knots) else float(knot)


def new_function(knots: Array, degree: int, knot: float, layers: int) -> int:
    """Index of a basis function of the refined direction that the old ones do not span.

    It is one with a share in the vector that all columns of the insertion matrix are
    orthogonal to; the largest share makes the function most independent. The matrix has
    alpha_i and 1 - alpha_i in row i (Boehm 1980), so the shares follow one from the other.

    Examples
    --------
    >>> new_function(np.array([0.0, 0, 1, 1]), 1, 0.5, 0)
    1
    """
    span = int(np.searchsorted(knots, knot, side="right")) - 1
    multiplicity = int((knots == knot).sum())
    index = np.arange(span - degree, span - multiplicity + 2)
    alpha = np.ones(len(index))
    inner = index[1:-1]
    alpha[1:-1] = (knot - knots[inner]) / (knots[inner + degree] - knots[inner])
    alpha[-1] = 0.0
    shares = np.concatenate([[1.0], np.cumprod(alpha[:-1] / (1 - alpha[1:]))])
    allowed = (index >= layers) & (index < len(knots) - degree - layers)
    return int(index[np.argmax(np.where(allowed, shares, -1.0))])


def _coordinates(basis: Any, columns: Any) -> Any:
    """Least-squares coordinates of columns in a sparse basis of full rank."""
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu

    solve = splu((basis.T @ basis).tocsc())
    return csr_array(solve.solve((basis.T @ columns).toarray()))
