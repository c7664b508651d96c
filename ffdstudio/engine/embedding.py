"""The embedding: points bound to a lattice, solved once, deformed often."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Array
from ffdstudio.engine.deformation import Deformer, check_space
from ffdstudio.engine.inversion import Inversion, invert
from ffdstudio.engine.knots import numbers
from ffdstudio.engine.lattice import Lattice
from ffdstudio.errors import InputError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from ffdstudio.engine.drag import Drag


def embed(
    lattice: Lattice, points: ArrayLike, method: str = "newton", tolerance: float = 1e-12
) -> Embedding:
    """Find the parametric coordinates of points in a lattice: the inverse problem.

    Parameters
    ----------
    lattice : Lattice
        The lattice at rest; any net, curved or weighted.
    points : array_like
        (n, 3) coordinates, world units. A float64 array is kept, not copied: do not write
        into it as long as the embedding is used.
    method : {"newton", "secant", "octree", "golden"}
        How the inverse problem is solved. Boxes at rest are solved in closed form and nets
        that have singular cells by Newton there, whatever the method.
    tolerance : float
        Distance ``|R(u) - x|`` to reach, as a fraction of the diagonal of the net.

    Returns
    -------
    Embedding
        With the parameters, and for each point whether it is inside, the residual and the
        number of evaluations. A point that lies outside a face by less than 1e-9 of the
        diagonal counts as on it.

    Raises
    ------
    InputError
        If the points are not (n, 3) finite numbers, method or tolerance are wrong, or the net
        is flat, or folded as a whole (corners in a wrong order).

    Notes
    -----
    With fewer than three directions a point belongs to the lattice by its coordinates along
    the lattice's axes alone.

    Examples
    --------
    >>> box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 4, 4))
    >>> embedding = embed(box, [[0.5, 0.25, 1.0], [2.0, 0.0, 0.0]])
    >>> embedding.inside
    array([ True, False])
    >>> raised = box.control_points + [0, 0, 0.5]
    >>> embedding.deform(box.moved(raised))
    array([[0.5 , 0.25, 1.5 ],
           [2.  , 0.  , 0.  ]])
    """
    known = isinstance(points, np.ndarray) and points.dtype == np.float64
    array = np.ascontiguousarray(points if known else numbers(points, "points to embed"))
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"points to embed must be an array (n, 3), got {array.shape}")
    with np.errstate(over="ignore", invalid="ignore"):
        finite = np.isfinite(array.sum())  # one pass, without an array of its own
    if not finite and not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise InputError(f"point {row} to embed has coordinates that are not finite numbers")
    array = array.view()
    array.flags.writeable = False
    return Embedding(lattice, array, invert(lattice, array, method, tolerance))


class Embedding:
    """Points bound to a lattice at rest; made by `embed`.

    Attributes
    ----------
    lattice : Lattice
        The lattice at rest.
    points : numpy.ndarray
        (n, 3) undeformed points.
    inside : numpy.ndarray
        (n,) bool; points outside are never moved.
    residual : numpy.ndarray
        (n,) distance ``|R(u) - x|`` along the lattice's axes; infinite outside.
    iterations : numpy.ndarray
        (n,) evaluations of R that the search needed; 0 in closed form.

    Examples
    --------
    >>> from ffdstudio import Lattice, embed
    >>> box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(2, 2, 2))
    >>> embedding = embed(box, [[0.5, 0.5, 0.5], [2, 0, 0]])
    >>> embedding.inside
    array([ True, False])
    >>> embedding.deform(box.moved(box.control_points * [1, 1, 3]))
    array([[0.5, 0.5, 1.5],
           [2. , 0. , 0. ]])
    """

    def __init__(self, lattice: Lattice, points: Array, found: Inversion) -> None:
        self.lattice = lattice
        self.points = points
        self.inside: NDArray[np.bool_] = found.inside
        self.residual = found.residual
        self.iterations = found.iterations
        self._deformer = Deformer(lattice, points, found.parameters, found.inside)

    def __repr__(self) -> str:
        inside = int(self.inside.sum())
        return f"Embedding({inside} of {len(self.points)} points inside {self.lattice})"

    def __len__(self) -> int:
        return len(self.points)

    @property
    def parameters(self) -> Array:
        """(n, d) parametric coordinates, NaN for points outside.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> bound.parameters
        array([[0.5],
               [nan]])
        """
        return self._deformer.parameters()

    def deform(self, current: Lattice, out: Array | None = None) -> Array:
        """Deformed points x0 + R(u; current) - R(u; rest).

        Parameters
        ----------
        current : Lattice
            The lattice with moved control points or weights; degrees and knots of the rest.
        out : numpy.ndarray, optional
            (n, 3) array to write into.

        Returns
        -------
        numpy.ndarray
            (n, 3). Points outside, and points that no change reaches, keep their bits.

        Raises
        ------
        InputError
            If `current` has other degrees or knots than the rest lattice.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> bound.deform(line.moved([[0, 0, 0], [2, 4, 0]]))
        array([[0.5, 8. , 7. ],
               [3. , 0. , 0. ]])
        """
        return self._deformer.deform(current, out)

    def drag(self, current: Lattice, control_points: ArrayLike) -> Drag:
        """Prepare moving some control points by one common vector, weights fixed.

        Parameters
        ----------
        current : Lattice
            The lattice when the drag begins.
        control_points : array_like
            Flat indices of the control points that move.

        Returns
        -------
        Drag
            With the points that follow, their shares, and `move`.

        Raises
        ------
        InputError
            If there are no such control points.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> points = bound.deform(line)
        >>> bound.drag(line, [1]).move([0, 4, 0], points)
        array([[0.5, 8. , 7. ],
               [3. , 0. , 0. ]])
        """
        from ffdstudio.engine.drag import Drag

        return Drag(self._deformer, current, control_points)

    def jacobian(self, current: Lattice) -> csr_array:
        """Sparse (n, number of control points) derivative of points by control points.

        The same for each coordinate: dx/dP_i = w_i B_i(u) / W(u). Rows outside are empty.

        Parameters
        ----------
        current : Lattice
            State of the lattice, of the same directions as the one at rest.

        Returns
        -------
        scipy.sparse.csr_array
            (n, number of control points), the last direction running fastest; no unit.

        Raises
        ------
        InputError
            If the lattice has other degrees or knots than the one at rest.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> bound.jacobian(line).toarray()
        array([[0.75, 0.25],
               [0.  , 0.  ]])
        """
        from ffdstudio.engine.jacobians import jacobian

        check_space(self.lattice, current)
        return jacobian(current, self.parameters, self.inside)

    def weight_jacobian(self, current: Lattice) -> Array:
        """(n, 3, number of control points) derivative of points by weights.

        dx/dw_i = B_i(u) (P_i - R(u)) / W(u).

        Parameters
        ----------
        current : Lattice
            State of the lattice, of the same directions as the one at rest.

        Returns
        -------
        numpy.ndarray
            (n, 3, number of control points), world units; zero in rows outside.

        Raises
        ------
        InputError
            If the lattice has other degrees or knots than the one at rest.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> bound.weight_jacobian(line)[0, 0]
        array([-0.375,  0.375])
        """
        from ffdstudio.engine.jacobians import weight_jacobian

        check_space(self.lattice, current)
        return weight_jacobian(current, self.parameters, self.inside)

    def jacobian_product(self, current: Lattice, d_points: ArrayLike) -> Array:
        """(n, 3) motion of the points per motion of the control points, without a matrix.

        Parameters
        ----------
        current : Lattice
            State of the lattice.
        d_points : array_like
            Motion of the control points, shaped like them.

        Returns
        -------
        numpy.ndarray
            (n, 3) motion of the points, zero outside; in the unit of `d_points`.

        Raises
        ------
        InputError
            If `d_points` has another shape or the lattice other degrees or knots.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> bound.jacobian_product(line, [[0, 0, 0], [0, 0, 4]])[0]
        array([0., 0., 1.])
        """
        from ffdstudio.engine.products import jacobian_product

        return jacobian_product(self._deformer, current, d_points)

    def jacobian_pullback(self, current: Lattice, sensitivities: ArrayLike) -> Array:
        """Gradient by the control points from that by the points, without a matrix.

        Parameters
        ----------
        current : Lattice
            State of the lattice.
        sensitivities : array_like
            (n, 3) derivatives of an objective by the deformed points.

        Returns
        -------
        numpy.ndarray
            Shaped like the control points; the same bits on any number of cores.

        Raises
        ------
        InputError
            If `sensitivities` has another shape or the lattice other degrees or knots.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> bound.jacobian_pullback(line, [[0, 0, 4], [0, 0, 9]])
        array([[0., 0., 3.],
               [0., 0., 1.]])
        """
        from ffdstudio.engine.products import jacobian_pullback

        return jacobian_pullback(self._deformer, current, sensitivities)

    def weight_product(self, current: Lattice, d_weights: ArrayLike) -> Array:
        """(n, 3) motion of the points per change of the weights, without a matrix.

        Parameters
        ----------
        current : Lattice
            State of the lattice, of the same directions as the one at rest.
        d_weights : array_like
            Change of the weights, shaped like them.

        Returns
        -------
        numpy.ndarray
            (n, 3) motion of the points, zero outside; world units.

        Raises
        ------
        InputError
            If `d_weights` has another shape or the lattice other degrees or knots.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> bound.weight_product(line, [0, 1])[0]
        array([0.375, 0.   , 0.   ])
        """
        from ffdstudio.engine.products import weight_product

        return weight_product(self._deformer, current, d_weights)

    def weight_pullback(self, current: Lattice, sensitivities: ArrayLike) -> Array:
        """Gradient by the weights from that by the points, without a matrix.

        Parameters
        ----------
        current : Lattice
            State of the lattice, of the same directions as the one at rest.
        sensitivities : array_like
            (n, 3) derivatives of an objective by the deformed points.

        Returns
        -------
        numpy.ndarray
            Shaped like the weights; the same bits on any number of cores.

        Raises
        ------
        InputError
            If `sensitivities` has another shape or the lattice other degrees or knots.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> bound.weight_pullback(line, [[8, 0, 0], [0, 0, 0]])
        array([-3.,  3.])
        """
        from ffdstudio.engine.products import weight_pullback

        return weight_pullback(self._deformer, current, sensitivities)

    def refined(self, finer: Lattice) -> Embedding:
        """The same points in a refined rest lattice; nothing is solved again.

        Parameters
        ----------
        finer : Lattice
            The rest lattice after knots were inserted or removed or degrees raised.

        Returns
        -------
        Embedding
            Of the same points, with the same parameters.

        Raises
        ------
        InputError
            If the domains of the two lattices differ, so that parameters cannot carry over.

        Examples
        --------
        >>> from ffdstudio import Lattice, embed
        >>> line = Lattice.box([0], [2], shape=(2,))
        >>> bound = embed(line, [[0.5, 7, 7], [3, 0, 0]])
        >>> finer = line.insert_knots(0, [1.0])
        >>> bound.refined(finer).jacobian(finer).toarray()[0]
        array([0.5, 0.5, 0. ])
        """
        if not np.array_equal(finer.domain, self.lattice.domain):
            raise InputError(
                "an embedding carries over to a refined lattice only if the range of the "
                "parameters stays the same"
            )
        found = Inversion(self.parameters, self.inside, self.residual, self.iterations)
        return Embedding(finer, self.points, found)
