"""One parametric direction: degree and knots, clamped at its ends or periodic.

1. A clamped direction of n control points of degree p has n + p + 1 knots, p + 1 equal ones at
   each end. A periodic one closes on itself: its n control points are used around and around,
   and so are its knots t, with t[j + n] = t[j] + period. Written down are n + 2 p + 1 of them,
   as SciPy does; the range of the parameter is t[p] to t[n + p].
2. A periodic direction has no ends: at the seam, where the range closes, it is as smooth as at
   any other knot. Function i and function i + n are the same one.
3. Refinement of either kind is a matrix on homogeneous control points (see `transfer`); a
   periodic direction is refined on a long piece of its endless knots.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine import knots as kv
from ffdstudio.engine import transfer
from ffdstudio.engine.basis import basis
from ffdstudio.errors import InputError

CLOSES = 1e-12  # of the period: how well the knots of one turn repeat those of the other


@dataclass(frozen=True, eq=False, slots=True)
class Direction:
    """Degree and knots of one parametric direction.

    Attributes
    ----------
    degree : int
    knots : numpy.ndarray
        Read-only; (n + p + 1,) if clamped, (n + 2 p + 1,) if periodic.
    periodic : bool

    Examples
    --------
    >>> ring = Direction.uniform(8, 3, 0.0, 1.0, periodic=True)
    >>> ring.count, ring.domain
    (8, (0.0, 1.0))
    >>> index, values = ring.functions([0.0])
    >>> index.tolist(), (6 * values).round(12).tolist()
    ([[0, 1, 2, 3]], [[1.0, 4.0, 1.0, 0.0]])
    """

    degree: int
    knots: Array
    periodic: bool = False

    @classmethod
    def checked(
        cls, knots: ArrayLike, degree: int, count: int, name: str = "", periodic: bool = False
    ) -> Direction:
        """Direction of `count` control points; `InputError` says what is wrong with the knots."""
        if not periodic:
            values = kv.checked(knots, degree, count, name)
        else:
            values = _checked_periodic(knots, degree, count, name)
        values.flags.writeable = False
        return cls(int(degree), values, bool(periodic))

    @classmethod
    def uniform(
        cls, count: int, degree: int, lower: float, upper: float, periodic: bool = False
    ) -> Direction:
        """Equally long knot spans from `lower` to `upper`."""
        if not periodic:
            return cls.checked(kv.clamped_uniform(count, degree, lower, upper), degree, count)
        turn = np.linspace(lower, upper, count + 1)[1:]
        return cls.checked(_unrolled(turn, lower, degree), degree, count, periodic=True)

    @property
    def count(self) -> int:
        """Number of control points."""
        return len(self.knots) - (2 if self.periodic else 1) * self.degree - 1

    @property
    def domain(self) -> tuple[float, float]:
        """Lowest and highest parameter."""
        return float(self.knots[self.degree]), float(self.knots[-self.degree - 1])

    @property
    def breaks(self) -> Array:
        """Distinct knots of the range, in ascending order: the ends of the knot spans."""
        p = self.degree
        return np.unique(self.knots[p : len(self.knots) - p])

    def greville(self) -> Array:
        """Greville abscissae (n,); the first ones of a periodic direction precede the range."""
        return kv.greville(self.knots, self.degree)[: self.count]

    def same(self, other: Direction) -> bool:
        """Whether parameters mean the same in both."""
        alike = (self.degree, self.periodic) == (other.degree, other.periodic)
        return alike and np.array_equal(self.knots, other.knots)

    def functions(self, u: ArrayLike, derivative: int = 0) -> tuple[NDArray[np.intp], Array]:
        """Control points that count at each parameter, and the values of their functions.

        Returns
        -------
        index : numpy.ndarray
            (n, p + 1) numbers of control points.
        values : numpy.ndarray
            (n, p + 1) values, or derivatives of the given order.
        """
        first, values = basis(self.knots, self.degree, np.asarray(u, np.float64), derivative)
        index = first[:, None] + np.arange(self.degree + 1)
        return (index % self.count if self.periodic else index), values

    def matrix(self, u: ArrayLike, derivative: int = 0) -> Array:
        """(n, control points) values of all functions at each parameter."""
        index, values = self.functions(u, derivative)
        out = np.zeros((len(index), self.count))
        np.put_along_axis(out, index, values, axis=1)
        return out

    def inserted(self, new: Array) -> tuple[Direction, Array]:
        """Direction with more knots and the matrix from old to new control points."""
        if not self.periodic:
            knots, matrix = transfer.insertion(self.knots, self.degree, new)
            return self._with(knots), matrix
        low, high = self.domain
        turn = np.sort(np.concatenate([self._turn(), np.where(new == low, high, new)]))
        return self._with(_unrolled(turn, low, self.degree)), self._carried(turn, 0)

    def elevated(self) -> tuple[Direction, Array]:
        """Direction of the next degree and the matrix to its control points."""
        p = self.degree
        if not self.periodic:
            knots, matrix = transfer.elevation(self.knots, p)
            return self._with(knots, p + 1), matrix
        values, multiplicity = np.unique(self._turn(), return_counts=True)
        turn = np.repeat(values, multiplicity + 1)
        return self._with(_unrolled(turn, self.domain[0], p + 1), p + 1), self._carried(turn, 1)

    def removed(self, gone: Array) -> tuple[Direction, Array, Array]:
        """Direction without some inner knots, the matrix to it, and the one back."""
        if not self.periodic:
            knots, matrix, back = transfer.removal(self.knots, self.degree, gone)
            return self._with(knots), matrix, back
        turn = self._turn()
        for knot in np.where(gone == self.domain[0], self.domain[1], gone):
            turn = np.delete(turn, np.flatnonzero(turn == knot)[0])
        coarser = self._with(_unrolled(turn, self.domain[0], self.degree))
        back = coarser.inserted(gone)[1]
        return coarser, np.asarray(np.linalg.pinv(back), np.float64), back

    def clamped(self) -> tuple[Direction, Array]:
        """The same functions with ends at the seam, and the matrix to the control points."""
        if not self.periodic:
            return self, np.eye(self.count)
        (low, high), p = self.domain, self.degree
        inner = self._turn()
        knots = np.concatenate([np.full(p + 1, low), inner[inner < high], np.full(p + 1, high)])
        windows = [knots[i + 1 : i + p + 1] for i in range(len(knots) - p - 1)]
        return Direction(p, _read_only(knots)), self._blossoms(windows, p)

    def most(self, knot: float) -> int:
        """How often a knot occurs in the range, the seam of a periodic one counting once."""
        values = self._turn() if self.periodic else self.knots
        if self.periodic and knot == self.domain[0]:
            knot = self.domain[1]
        return int((values == knot).sum())

    def _turn(self) -> Array:
        """The n knots of one turn, the end of the range among them, its beginning not."""
        return self.knots[self.degree + 1 : self.degree + 1 + self.count]

    def _with(self, knots: Array, degree: int | None = None) -> Direction:
        return Direction(
            self.degree if degree is None else degree, _read_only(knots), self.periodic
        )

    def _carried(self, turn: Array, more: int) -> Array:
        """Matrix to the control points over another turn, of a degree higher by `more`."""
        p = self.degree + more
        knots = _endless(turn, *self.domain)
        first = 2 * len(turn) - p  # where the knots of function 0 begin, but for its first one
        return self._blossoms([knots[first + i : first + i + p] for i in range(len(turn))], p)

    def _blossoms(self, windows: list[Array], degree: int) -> Array:
        """(windows, control points) weights of the blossom of a spline of `degree` there."""
        knots, n = _endless(self._turn(), *self.domain), self.count
        count = len(knots) - self.degree - 1
        shift = 2 * n - self.degree - 1  # of function 0 in the endless numbering
        matrix = np.zeros((len(windows), n))
        for row, window in zip(matrix, windows, strict=True):
            long = transfer.blossom(knots, self.degree, window, count)
            np.add.at(row, (np.flatnonzero(long) - shift) % n, long[long != 0])
        return transfer.without_dust(matrix)


def _read_only(knots: Array) -> Array:
    knots.flags.writeable = False
    return knots


def _unrolled(turn: Array, low: float, degree: int) -> Array:
    """(n + 2 p + 1) knots of a periodic direction from those of one turn."""
    high, n, p = turn[-1], len(turn), degree
    before = np.where(turn == high, low, turn - (high - low))
    return np.concatenate([before[n - p - 1 :], turn, (turn + (high - low))[:p]])


def _endless(turn: Array, low: float, high: float) -> Array:
    """Five turns of knots, the third of which is the range."""
    return np.concatenate([turn + k * (high - low) for k in (-2, -1, 0, 1, 2)])


def _checked_periodic(knots: ArrayLike, degree: int, count: int, name: str) -> Array:
    where = f" in direction {name}" if name else ""
    values = kv.numbers(knots, f"the knots{where}")
    kv.check_degree(count, degree, name)
    p = int(degree)
    if values.shape != (count + 2 * p + 1,):
        raise InputError(
            f"{count} control points of degree {p}{where}, which is periodic, need "
            f"{count + 2 * p + 1} knots, got {values.size}"
        )
    if not np.isfinite(values).all():
        raise InputError(f"the knots{where} must be finite numbers")
    if (np.diff(values) < 0).any():
        raise InputError(f"the knots{where} must not decrease")
    period = values[count + p] - values[p]
    if (
        not period > 0
        or not (
            np.abs(values[count:] - values[: 2 * p + 1] - period)
            <= CLOSES * max(period, float(np.abs(values).max()))
        ).all()
    ):
        raise InputError(f"the knots{where} must repeat after {count} of them, by one period")
    if values[p] == values[p + 1]:
        raise InputError(f"the range{where} must begin at the last of several equal knots")
    if (values[p + 1 + p :] == values[p + 1 : -p]).any():
        raise InputError(f"a knot{where} may occur at most {p} times")
    low, turn = float(values[p]), values[p + 1 : p + 1 + count]
    kv.check_gaps(np.concatenate([[low], turn]), name)
    return _unrolled(turn, low, p)
