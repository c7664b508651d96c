"""The lattice: a NURBS map of one, two or three parametric directions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.engine import knots as kv
from ffdstudio.engine import refinement
from ffdstudio.engine.boxes import Frame, box_net, complete_axes
from ffdstudio.engine.evaluate import evaluate
from ffdstudio.engine.knots import DIRECTIONS
from ffdstudio.engine.transfer import along
from ffdstudio.errors import InputError
from ffdstudio.limits import check_control_points


class Lattice:
    """A control net with degrees, knots and weights. An immutable value: edits return a new one.

    Parameters
    ----------
    degrees : sequence of int
        Degree of each parametric direction, ``1 <= p <= a`` for ``a + 1`` control points.
    knots : sequence of array_like
        A clamped knot vector for each direction.
    control_points : array_like
        (a+1, b+1, c+1, 3) in world units; (a+1, b+1, 3) and (a+1, 3) for lattices of two
        and one directions.
    weights : array_like, optional
        (a+1, b+1, c+1) positive and finite; 1 by default.
    axes : array_like, optional
        (d, 3) orthonormal vectors, d the number of directions. With d < 3 a point belongs to
        the lattice by its coordinates along these axes alone. Default: the first d
        coordinate axes.

    Attributes
    ----------
    degrees : tuple of int
    knots : tuple of numpy.ndarray
    control_points, weights, axes : numpy.ndarray
        Read-only float64 arrays.

    Raises
    ------
    InputError
        If degrees, knots, points or weights do not fit together.

    Examples
    --------
    >>> box = Lattice.box([0, 0, 0], [2, 1, 1], shape=(4, 3, 2), degrees=(3, 2, 1))
    >>> box.evaluate([[0.5, 0.25, 1.0]])
    array([[0.5 , 0.25, 1.  ]])
    """

    __slots__ = ("__weakref__", "axes", "control_points", "degrees", "knots", "weights")

    degrees: tuple[int, ...]
    knots: tuple[Array, ...]
    control_points: Array
    weights: Array
    axes: Array

    def __init__(
        self,
        degrees: Sequence[int],
        knots: Sequence[ArrayLike],
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
        axes: ArrayLike | None = None,
    ) -> None:
        points = _points(control_points)
        shape = points.shape[:-1]
        check_control_points(shape)
        if len(degrees) != len(shape) or len(knots) != len(shape):
            raise InputError(
                f"a net of {len(shape)} directions needs as many degrees and knot vectors, "
                f"got {len(degrees)} and {len(knots)}"
            )
        checked = [
            kv.checked(knots[k], degrees[k], shape[k], DIRECTIONS[k]) for k in range(len(shape))
        ]
        self._set(degrees, checked, points, _weights(weights, shape), complete_axes(axes, shape))

    def _set(
        self,
        degrees: Sequence[int],
        knots: Sequence[Array],
        points: Array,
        weights: Array,
        axes: Array,
    ) -> None:
        for array in (*knots, points, weights, axes):
            array.flags.writeable = False
        fields = {
            "degrees": tuple(int(p) for p in degrees),
            "knots": tuple(knots),
            "control_points": points,
            "weights": weights,
            "axes": axes,
        }
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a lattice is an immutable value; use moved() to get another one")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("a lattice is an immutable value")

    def __reduce__(self) -> tuple[object, ...]:
        return Lattice, (self.degrees, self.knots, self.control_points, self.weights, self.axes)

    def __repr__(self) -> str:
        counts = "x".join(str(n) for n in self.shape)
        return f"Lattice({counts}, degrees={self.degrees})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Lattice):
            return NotImplemented
        return (
            self.same_space(other)
            and np.array_equal(self.control_points, other.control_points)
            and np.array_equal(self.weights, other.weights)
            and np.array_equal(self.axes, other.axes)
        )

    __hash__ = None  # type: ignore[assignment]

    # ---- making one -------------------------------------------------------------------

    @classmethod
    def box(
        cls,
        lower: ArrayLike,
        upper: ArrayLike,
        shape: Sequence[int] = (8, 6, 4),
        degrees: Sequence[int] | None = None,
        axes: ArrayLike | None = None,
        spacing: str = "greville",
    ) -> Self:
        """Lattice that fills a box; the parameters are the coordinates in its frame.

        Parameters
        ----------
        lower, upper : array_like
            (3,) corners in the frame of `axes`; the entries of unused axes are ignored.
        shape : sequence of int
            Control points of each direction; its length is the number of directions.
        degrees : sequence of int, optional
            Default: 3, or less where the direction has too few points.
        axes : array_like, optional
            (d, 3) orthonormal vectors of the frame. Default: the first d coordinate axes.
        spacing : {"greville", "uniform"}
            "greville" makes the undeformed lattice the identity; "uniform" spaces the
            control points equally, as the paper does.

        Raises
        ------
        InputError
            If the box has no extent, or degrees and shape do not fit.

        Examples
        --------
        >>> Lattice.box([0, 0, 0], [1, 1, 1], shape=(5, 2)).control_points[:, 0, 0]
        array([0.        , 0.16666667, 0.5       , 0.83333333, 1.        ])
        """
        knots, points, directions, degrees = box_net(lower, upper, shape, degrees, axes, spacing)
        return cls(degrees, knots, points, axes=directions)

    @classmethod
    def around(
        cls,
        points: ArrayLike,
        shape: Sequence[int] = (8, 6, 4),
        degrees: Sequence[int] | None = None,
        margin: ArrayLike = 0.05,
        axes: ArrayLike | None = None,
        spacing: str = "greville",
    ) -> Self:
        """Box lattice around (n, 3) points.

        Parameters
        ----------
        points : array_like
            (n, 3) finite coordinates; n >= 1.
        margin : float or array_like
            Distance from the points to the faces as a fraction of the extent in that
            direction (a direction without extent takes the largest one); one for all
            directions or one for each.

        See `box` for the other parameters and for the errors raised.

        Examples
        --------
        >>> lattice = Lattice.around([[0, 0, 0], [1, 2, 0]], shape=(2, 2), margin=0.1)
        >>> lattice.control_points[0, 0]
        array([-0.1, -0.2,  0. ])
        """
        frame = Frame.of(axes, len(shape))
        lower, upper = frame.bounds(points, margin)
        return cls.box(lower, upper, shape, degrees, axes, spacing)

    def moved(
        self, control_points: ArrayLike | None = None, weights: ArrayLike | None = None
    ) -> Self:
        """Same lattice with other control points or weights; what is not given stays.

        Examples
        --------
        >>> box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(2, 2, 2))
        >>> box.moved(box.control_points + [0, 0, 1]).evaluate([[0, 0, 0]])
        array([[0., 0., 1.]])
        """
        points = self.control_points if control_points is None else _points(control_points)
        if points.shape != self.control_points.shape:
            raise InputError(
                f"the control points of this lattice have shape {self.control_points.shape}, "
                f"got {points.shape}"
            )
        new_weights = self.weights if weights is None else _weights(weights, self.shape)
        return self._with(self.degrees, self.knots, points, new_weights)

    def _with(
        self, degrees: Sequence[int], knots: Sequence[Array], points: Array, weights: Array
    ) -> Self:
        """Make a sibling without checking again what is known to be right."""
        new = object.__new__(type(self))
        new._set(degrees, knots, points, weights, self.axes)
        return new

    # ---- what it is -------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, ...]:
        """Control points in each direction.

        Examples
        --------
        >>> Lattice.box([0, 0], [1, 1], shape=(5, 4)).shape
        (5, 4)
        """
        return self.weights.shape

    @property
    def dimension(self) -> int:
        """Number of parametric directions, 1 to 3.

        Examples
        --------
        >>> Lattice.box([0, 0], [1, 1], shape=(5, 4)).dimension
        2
        """
        return len(self.degrees)

    @property
    def diagonal(self) -> float:
        """Diagonal of the bounding box of the control points, the length that tolerances refer to.

        With fewer than three directions it is measured along the lattice's axes.

        Examples
        --------
        >>> Lattice.box([0, 0], [3, 4], shape=(2, 2)).diagonal
        5.0
        """
        flat = self.control_points.reshape(-1, 3) @ self.axes.T
        return float(np.linalg.norm(np.ptp(flat, axis=0)))

    @property
    def domain(self) -> Array:
        """(d, 2) lowest and highest parameter of each direction.

        Examples
        --------
        >>> Lattice.box([0, 0], [3, 4], shape=(2, 2)).domain
        array([[0., 3.],
               [0., 4.]])
        """
        return np.array([[u[0], u[-1]] for u in self.knots])

    @property
    def homogeneous(self) -> Array:
        """(..., 4) control points times weight, and the weight.

        Examples
        --------
        >>> Lattice([1], [[0, 0, 1, 1]], [[0, 0, 0], [3, 0, 0]], weights=[1, 2]).homogeneous
        array([[0., 0., 0., 1.],
               [6., 0., 0., 2.]])
        """
        w = self.weights[..., None]
        return np.concatenate([self.control_points * w, w], axis=-1)

    def same_space(self, other: Lattice) -> bool:
        """Whether both have the same degrees and knots, so that parameters mean the same.

        Examples
        --------
        >>> box = Lattice.box([0, 0], [1, 1], shape=(4, 4))
        >>> box.same_space(box.moved(box.control_points + 1))
        True
        >>> box.same_space(box.insert_knots(0, [0.5]))
        False
        """
        return self.degrees == other.degrees and all(
            np.array_equal(a, b) for a, b in zip(self.knots, other.knots, strict=True)
        )

    def greville(self, axis: int) -> Array:
        """Greville abscissae of one direction.

        Examples
        --------
        >>> Lattice.box([0, 0], [1, 1], shape=(4, 3)).greville(1)
        array([0. , 0.5, 1. ])
        """
        return kv.greville(self.knots[axis], self.degrees[axis])

    def evaluate(self, uvw: ArrayLike, derivative: Sequence[int] | None = None) -> Array:
        """Points R(u, v, w), or a partial derivative of total order 1 or 2.

        Parameters
        ----------
        uvw : array_like
            (n, d) parametric coordinates inside the domain.
        derivative : sequence of int, optional
            Order by direction, for example ``(1, 0, 1)`` for d2R / du dw.

        Returns
        -------
        numpy.ndarray
            (n, 3) points, or derivatives by the parameters.

        Raises
        ------
        InputError
            If a parameter lies outside the domain or the order exceeds 2.

        Examples
        --------
        >>> line = Lattice([1], [[0, 0, 2, 2]], [[0, 0, 0], [4, 0, 0]])
        >>> line.evaluate([[1.0]], derivative=[1])
        array([[2., 0., 0.]])
        """
        return evaluate(self, uvw, derivative)

    # ---- refinement: exact, on deformed and weighted lattices as well -------------------

    def insert_knots(self, axis: int, knots: ArrayLike) -> Self:
        """Same shape with more control points: knots inserted in one direction.

        Raises
        ------
        InputError
            If a knot lies outside the range, or would occur more often than the degree.

        Examples
        --------
        >>> box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(2, 2, 2))
        >>> box.insert_knots(0, [0.5]).shape
        (3, 2, 2)
        """
        return self._carried(*refinement.insertion(self, axis, knots))

    def elevate_degree(self, axis: int, times: int = 1) -> Self:
        """Same shape with the degree of one direction raised by `times`.

        Examples
        --------
        >>> Lattice.box([0, 0, 0], [1, 1, 1], shape=(2, 2, 2)).elevate_degree(1).degrees
        (1, 2, 1)
        """
        new = self
        for _ in range(refinement.checked_times(times)):
            new = new._carried(*refinement.elevation(new, axis))
        return new

    def remove_knots(self, axis: int, knots: ArrayLike, tolerance: float = 0.0) -> Self:
        """Coarser lattice without the given knots, if the shape stays within `tolerance`.

        Parameters
        ----------
        axis : int
            Direction.
        knots : array_like
            Inner knots, repeated if more than one of a multiple knot shall go.
        tolerance : float
            Largest distance any point may move, world units. Rounding (1e-13 of the
            diagonal, and that of the coordinates themselves) is always allowed.

        Raises
        ------
        InputError
            If a knot is not there or the shape would move by more than `tolerance`.

        Examples
        --------
        >>> box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(3, 2, 2), degrees=(2, 1, 1))
        >>> box.insert_knots(0, [0.5]).remove_knots(0, [0.5]).shape
        (3, 2, 2)
        """
        return self._carried(*refinement.removal(self, axis, knots, tolerance))

    def _carried(self, axis: int, degree: int, knots: Array, matrix: Array) -> Self:
        """Lattice whose homogeneous control points are `matrix` times these along `axis`."""
        degrees, all_knots = list(self.degrees), list(self.knots)
        degrees[axis], all_knots[axis] = degree, knots
        if (self.weights == 1).all():  # keep exact ones: the unweighted case is the fast one
            points = along(matrix, self.control_points, axis)
            return self._with(degrees, all_knots, points, np.ones(points.shape[:-1]))
        carried = along(matrix, self.homogeneous, axis)
        weights = carried[..., 3].copy()
        return self._with(degrees, all_knots, carried[..., :3] / weights[..., None], weights)


def _points(control_points: ArrayLike) -> Array:
    points = kv.numbers(control_points, "control points")
    if points.ndim not in (2, 3, 4) or points.shape[-1] != 3:
        raise InputError(
            "control points must be an array (a+1, 3), (a+1, b+1, 3) or (a+1, b+1, c+1, 3), "
            f"got {points.shape}"
        )
    if not np.isfinite(points).all():
        raise InputError("control points must be finite numbers")
    return points


def _weights(weights: ArrayLike | None, shape: tuple[int, ...]) -> Array:
    if weights is None:
        return np.ones(shape)
    values = kv.numbers(weights, "weights")
    if values.shape != shape:
        raise InputError(f"the weights of this lattice have shape {shape}, got {values.shape}")
    if not (np.isfinite(values).all() and (values > 0).all()):
        raise InputError("weights must be positive, finite numbers")
    return values
