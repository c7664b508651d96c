"""The lattice: a NURBS map of one, two or three parametric directions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ffdstudio.aliases import Array
from ffdstudio.engine import knots as kv
from ffdstudio.engine import refinement
from ffdstudio.engine.boxes import Frame as BoxFrame
from ffdstudio.engine.boxes import box_net, complete_axes
from ffdstudio.engine.direction import Direction
from ffdstudio.engine.evaluate import evaluate
from ffdstudio.engine.frames import Cylinder, Frame, cylinder_directions, cylinder_net
from ffdstudio.engine.knots import DIRECTIONS
from ffdstudio.engine.parts import checked_parts
from ffdstudio.engine.transfer import carried
from ffdstudio.errors import InputError
from ffdstudio.limits import MAX_WEIGHTS, check_control_points


class Lattice:
    """A control net with degrees, knots and weights. An immutable value: edits return a new one.

    Parameters
    ----------
    degrees : sequence of int
        Degree of each parametric direction, ``1 <= p <= a`` for ``a + 1`` control points.
    knots : sequence of array_like
        A knot vector for each direction: clamped, ``a + p + 2`` knots, or periodic,
        ``a + 2 p + 2`` of them that repeat after ``a + 1`` (see `engine.direction`).
    control_points : array_like
        (a+1, b+1, c+1, 3) in world units; (a+1, b+1, 3) and (a+1, 3) for lattices of two
        and one directions.
    weights : array_like, optional
        (a+1, b+1, c+1) positive and finite; 1 by default.
    axes : array_like, optional
        (d, 3) orthonormal vectors, d the number of directions. With d < 3 a point belongs to
        the lattice by its coordinates along these axes alone. Default: the first d
        coordinate axes.
    periodic : sequence of bool, optional
        Which directions close on themselves. Default: none.
    frame : Frame, optional
        Curved coordinates that the lattice at rest follows (see `engine.frames`).
    reference : Lattice, optional
        With a frame: a lattice of the same directions whose control points and weights leave
        the frame as it is. Default: this one.

    Attributes
    ----------
    directions : tuple of Direction
    control_points, weights, axes : numpy.ndarray
        Read-only float64 arrays.
    frame : Frame or None
    reference : Lattice or None

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

    __slots__ = (
        "axes", "control_points", "directions", "frame", "memo", "reference", "weights",
    )  # fmt: skip

    directions: tuple[Direction, ...]
    control_points: Array
    weights: Array
    axes: Array
    frame: Frame | None
    reference: Lattice | None
    memo: dict[str, Any]  # what the engine has made for this value; it goes with it

    def __init__(
        self,
        degrees: Sequence[int],
        knots: Sequence[ArrayLike],
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
        axes: ArrayLike | None = None,
        *,
        periodic: Sequence[bool] | None = None,
        frame: Frame | None = None,
        reference: Lattice | None = None,
    ) -> None:
        points = _points(control_points)
        shape = points.shape[:-1]
        check_control_points(shape)
        if len(degrees) != len(shape) or len(knots) != len(shape):
            raise InputError(
                f"a net of {len(shape)} directions needs as many degrees and knot vectors, "
                f"got {len(degrees)} and {len(knots)}"
            )
        closed = [False] * len(shape) if periodic is None else list(periodic)
        if len(closed) != len(shape):
            raise InputError(f"{len(shape)} directions are periodic or not, got {len(closed)}")
        checked = [
            Direction.checked(knots[k], degrees[k], shape[k], DIRECTIONS[k], closed[k])
            for k in range(len(shape))
        ]
        self._set(
            checked, points, _weights(weights, shape), complete_axes(axes, shape), frame, reference
        )

    def _set(
        self,
        directions: Sequence[Direction],
        points: Array,
        weights: Array,
        axes: Array,
        frame: Frame | None,
        reference: Lattice | None,
    ) -> None:
        for array in (points, weights, axes):
            array.flags.writeable = False
        fields: dict[str, Any] = {
            "directions": tuple(directions),
            "control_points": points,
            "weights": weights,
            "axes": axes,
            "frame": frame,
            "reference": None,
            "memo": {},
        }
        if frame is not None:
            fields["reference"] = self._spline(reference, fields)
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    @staticmethod
    def _spline(reference: Lattice | None, fields: dict[str, Any]) -> Lattice:
        """The lattice without its frame; a reference must have the same directions."""
        plain = object.__new__(Lattice)
        net = fields["control_points"], fields["weights"]
        if reference is not None:
            net = reference.control_points, reference.weights
            if net[1].shape != fields["weights"].shape:
                raise InputError("the reference of a lattice has other control points than it")
        plain._set(fields["directions"], *net, fields["axes"], None, None)
        return plain

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a lattice is an immutable value; use moved() to get another one")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("a lattice is an immutable value")

    def __reduce__(self) -> tuple[object, ...]:
        return Lattice.of_parts, (self.parts(),)

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
            and self.reference == other.reference
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
        frame = BoxFrame.of(axes, len(shape))
        lower, upper = frame.bounds(points, margin)
        return cls.box(lower, upper, shape, degrees, axes, spacing)

    @classmethod
    def cylinder(
        cls,
        radii: ArrayLike,
        angles: ArrayLike | None = None,
        heights: ArrayLike | None = None,
        shape: Sequence[int] = (4, 12, 4),
        degrees: Sequence[int] | None = None,
        origin: ArrayLike = (0.0, 0.0, 0.0),
        axis: ArrayLike = (0.0, 0.0, 1.0),
        start: ArrayLike | None = None,
    ) -> Self:
        """Lattice that fills a cylinder, a ring or a sector: radius, angle, height.

        At rest it is the cylinder exactly, and the parameters are the cylindrical coordinates. A
        full ring is periodic in the angle: it has no seam, whichever column moves.

        Parameters
        ----------
        radii : array_like
            (2,) inner and outer radius, the inner one 0 for a solid.
        angles : array_like, optional
            (2,) first and last angle of a sector in radians. Default: the full turn.
        heights : array_like
            (2,) lower and upper end along the axis; not given with two directions.
        shape : sequence of int
            Control points along radius and angle, or along radius, angle and height.
        degrees : sequence of int, optional
            Default: 3, or less where the direction has too few points.
        origin, axis, start : array_like
            (3,) a point of the axis, its direction, and the direction of angle 0 (by default the
            next coordinate direction).

        Raises
        ------
        InputError
            If radii, angles or heights do not ascend, or shape and degrees do not fit.

        Examples
        --------
        >>> ring = Lattice.cylinder((1, 2), heights=(0, 3), shape=(3, 8, 2))
        >>> ring.evaluate([[1.5, np.pi, 3.0]]).round(12)
        array([[-1.5,  0. ,  3. ]])
        """
        frame = Cylinder.of(origin, axis, start)
        directions = cylinder_directions(radii, angles, heights, shape, degrees)
        frame = replace(frame, order=frame.order[: len(directions)])
        points = cylinder_net(frame, directions)
        new = object.__new__(cls)
        axes = frame.axes[: len(directions)]
        new._set(directions, points, np.ones(points.shape[:-1]), axes, frame, None)
        return new

    def moved(
        self, control_points: ArrayLike | None = None, weights: ArrayLike | None = None
    ) -> Self:
        """Same lattice with other control points or weights; what is not given stays.

        Parameters
        ----------
        control_points : array_like, optional
            Shaped like the present ones, world units.
        weights : array_like, optional
            Positive, shaped like the present ones.

        Returns
        -------
        Lattice
            With the same directions, axes and frame.

        Raises
        ------
        InputError
            If a shape differs, or a number is not finite or a weight not positive.

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
        return self._with(self.directions, points, new_weights, self.reference)

    def _with(
        self,
        directions: Sequence[Direction],
        points: Array,
        weights: Array,
        reference: Lattice | None,
    ) -> Self:
        """Make a sibling without checking again what is known to be right."""
        new = object.__new__(type(self))
        new._set(directions, points, weights, self.axes, self.frame, reference)
        return new

    # ---- what it is -------------------------------------------------------------------

    @property
    def degrees(self) -> tuple[int, ...]:
        """Degree of each direction.

        Examples
        --------
        >>> Lattice.box([0, 0], [1, 1], shape=(5, 3)).degrees
        (3, 2)
        """
        return tuple(direction.degree for direction in self.directions)

    @property
    def knots(self) -> tuple[Array, ...]:
        """Knots of each direction; those of a periodic one go on beyond its range.

        Examples
        --------
        >>> Lattice.box([0], [1], shape=(3,)).knots
        (array([0., 0., 0., 1., 1., 1.]),)
        """
        return tuple(direction.knots for direction in self.directions)

    @property
    def periodic(self) -> tuple[bool, ...]:
        """Which directions close on themselves.

        Examples
        --------
        >>> Lattice.cylinder((1, 2), shape=(2, 8)).periodic
        (False, True)
        """
        return tuple(direction.periodic for direction in self.directions)

    @property
    def seams(self) -> tuple[tuple[int, int], ...]:
        """Direction and side of the ends that are none, for the direction is periodic.

        Examples
        --------
        >>> Lattice.cylinder((1, 2), shape=(2, 8)).seams
        ((1, 0), (1, 1))
        """
        closed = [k for k, periodic in enumerate(self.periodic) if periodic]
        return tuple((k, side) for k in closed for side in (0, 1))

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
        return np.array([direction.domain for direction in self.directions])

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
        return (
            len(self.directions) == len(other.directions)
            and all(a.same(b) for a, b in zip(self.directions, other.directions, strict=True))
            and self.frame == other.frame
        )

    def greville(self, axis: int) -> Array:
        """Greville abscissae of one direction.

        Parameters
        ----------
        axis : int
            Direction.

        Returns
        -------
        numpy.ndarray
            One parameter for each control point of the direction.

        Examples
        --------
        >>> Lattice.box([0, 0], [1, 1], shape=(4, 3)).greville(1)
        array([0. , 0.5, 1. ])
        """
        return self.directions[axis].greville()

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

        Parameters
        ----------
        axis : int
            Direction.
        knots : array_like
            Parameters inside the range, repeated for multiple knots; the beginning of a
            periodic range, its seam, is allowed.

        Returns
        -------
        Lattice
            The same map, weights and a frame included.

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

        Parameters
        ----------
        axis : int
            Direction.
        times : int
            0 or more.

        Returns
        -------
        Lattice
            The same map.

        Raises
        ------
        InputError
            If there is no such direction or `times` is no whole number of at least 0.

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

        Returns
        -------
        Lattice
            With as many control points fewer as knots are gone.

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

    def clamped(self) -> Self:
        """The same map with clamped directions alone; what is periodic gets ends at its seam.

        The control points on both sides of the seam are then free of each other.

        Examples
        --------
        >>> ring = Lattice.cylinder((1, 2), shape=(2, 8))
        >>> ring.clamped().shape, ring.clamped().periodic
        ((2, 11), (False, False))
        """
        if not any(self.periodic):
            return self
        if "clamped" not in self.memo:
            new = self
            for axis, direction in enumerate(self.directions):
                new = new._carried(axis, *direction.clamped())
            self.memo["clamped"] = new
        made: Self = self.memo["clamped"]
        return made

    # ---- as plain parts -----------------------------------------------------------------

    def parts(self) -> dict[str, Any]:
        """What the lattice is made of, for files: arrays, numbers and texts by name.

        "periodic", "frame" and "reference" are there only where they say something.

        Examples
        --------
        >>> line = Lattice.box([0], [1], shape=(2,))
        >>> list(line.parts()), Lattice.of_parts(line.parts()) == line
        (['degrees', 'knots', 'control_points', 'weights', 'axes'], True)
        """
        parts: dict[str, Any] = {
            "degrees": list(self.degrees),
            "knots": list(self.knots),
            "control_points": self.control_points,
            "weights": self.weights,
            "axes": self.axes,
        }
        if any(self.periodic):
            parts["periodic"] = list(self.periodic)
        if self.frame is not None and self.reference is not None:
            parts["frame"] = self.frame.parts()
            net = self.reference.control_points, self.reference.weights
            parts["reference"] = dict(zip(("control_points", "weights"), net, strict=True))
        return parts

    @classmethod
    def of_parts(cls, parts: Mapping[str, Any]) -> Self:
        """Lattice from what `parts` has made, the arrays as lists or not.

        Raises
        ------
        InputError
            If something is missing, unknown, or does not fit together.

        Examples
        --------
        >>> Lattice.of_parts({"degrees": [1], "knots": [[0, 0, 1, 1]], "control_points": [[0, 0]]})
        Traceback (most recent call last):
            ...
        ffdstudio.errors.InputError: control points must be an array (a+1, 3), (a+1, b+1, 3) or \
(a+1, b+1, c+1, 3), got (1, 2)
        """
        return cls(**checked_parts(parts, cls))

    def _carried(self, axis: int, direction: Direction, matrix: Array) -> Self:
        """Lattice whose homogeneous control points are `matrix` times these along `axis`."""
        directions = [*self.directions[:axis], direction, *self.directions[axis + 1 :]]
        points, weights = carried(self, axis, matrix)
        reference = self.reference
        if reference is not None:
            reference = reference._carried(axis, direction, matrix)
        return self._with(directions, points, weights, reference)


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
    if values.size and values.max() / MAX_WEIGHTS > values.min():
        raise InputError(
            f"the weights {values.min():g} and {values.max():g} of one lattice differ by more than "
            f"a factor of {MAX_WEIGHTS:g}"
        )
    return values
