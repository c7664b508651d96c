"""Inviscid, incompressible flow about an airfoil: linear-vorticity panels, exact adjoint.

1. The contour is a stream line: the stream function of the free stream and of vorticity that is
   linear on each straight panel takes one value at all nodes (M. Drela, XFOIL: an analysis and
   design system for low Reynolds number airfoils, 1989). The air inside is at rest, so that the
   vorticity of a node is the speed there. Points are complex numbers z = x + iy.
2. The Kutta condition: the vorticities at the two trailing-edge nodes cancel. An open trailing
   edge is closed by a panel whose source and vorticity let the air off at the edge's speed along
   the bisector; at a sharp one, where the equations of both nodes are the same, the second of
   them says that the air just inside is at rest along the bisector.
3. Speed and pressure at the middle of a panel are those of its mean vorticity, and forces are the
   pressures at the middles times the panels: of second order. On a Karman-Trefftz section of
   160 panels lift is within 0.03 %, drag within 1e-4 of nothing, on a cusp as well.
4. All angles of attack share two solutions, and lift, pressures and their derivatives the factors.
   The adjoint differentiates the expressions by the nodes: exact for the discrete equations.
5. Nodes run from the upper trailing edge over the nose to the lower one, so that the outside
   lies to the right of each panel.
6. Factors come from LAPACK on one thread: with more it is slower here, and rounds differently.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from contextlib import AbstractContextManager
from copy import copy
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.optimize.flow.kernels import kernels
from ffdstudio.optimize.flow.trailing_edge import Base, SharpEdge, bisector

Complex = NDArray[np.complex128]
REMEMBERED = 4  # contours
SHARP = 1e-4  # of the chord: a thinner trailing edge counts as sharp, as in XFOIL
JACOBIAN_SOLVES = 3  # flow solves that a Jacobian of the pressures costs, by time


class PanelFlow:
    """The flow about one contour at several angles of attack.

    Parameters
    ----------
    nodes : array_like
        (n + 1, 2+) nodes in Selig order.
    angles : array_like
        Angles of attack in degrees.

    Attributes
    ----------
    vorticity : numpy.ndarray
        (angles, n + 1) tangential velocity at the nodes over the free stream's, in their order.
    speed : numpy.ndarray
        (angles, n) the same at the panel middles.

    Raises
    ------
    InputError
        If there are fewer than 4 panels, two neighbouring nodes coincide, or the equations
        have no solution (a contour that crosses itself).

    Examples
    --------
    >>> angle = np.linspace(0, 2 * np.pi, 101)
    >>> circle = PanelFlow(np.column_stack([np.cos(angle), np.sin(angle)]), [0.0])
    >>> bool(abs(circle.pressure.min() + 3) < 0.01)  # Cp = 1 - 4 sin^2
    True
    """

    def __init__(self, nodes: ArrayLike, angles: ArrayLike) -> None:
        self.z = _complex(nodes)
        gap, chord = abs(self.z[0] - self.z[-1]), np.ptp(self.z.real)
        self.sharp = bool(gap < SHARP * chord)
        if self.sharp:  # both nodes are one
            self.z[[0, -1]] = 0.5 * (self.z[0] + self.z[-1])
        self.delta = np.diff(self.z)
        if not self.delta.all():
            raise InputError("the panel method needs finite nodes, neighbours apart")
        self._assemble()
        self._solve(angles)

    def _assemble(self) -> None:
        from scipy.linalg import lu_factor, lu_solve

        n = len(self.delta)
        matrix = np.zeros((n + 2, n + 2))
        self._logs, self._turns = np.empty((n + 1, n + 1)), np.empty((n + 1, n + 1))
        self._xy = np.ascontiguousarray(self.z.real), np.ascontiguousarray(self.z.imag)
        kernels()[0](*self._xy, self.sharp, matrix, self._logs, self._turns)
        matrix[: n + 1, n + 1] = -1.0
        matrix[n + 1, [0, n]] = 1.0
        load = np.zeros((n + 2, 2))  # of the free streams along x and along y
        load[: n + 1] = np.column_stack([-self.z.imag, self.z.real])
        self._edge = (SharpEdge if self.sharp else Base)(self.z, bisector(self.z))
        self._edge.enter(matrix, load)
        with one_thread():
            self._factors = lu_factor(matrix, overwrite_a=True, check_finite=False)
            self._solutions = lu_solve(self._factors, load, check_finite=False)[: n + 1].T

    def at(self, angles: ArrayLike) -> PanelFlow:
        """The flow about the same contour at other angles: nothing is solved again.

        Examples
        --------
        >>> angle = np.linspace(0, 2 * np.pi, 41)
        >>> nodes = np.column_stack([np.cos(angle), np.sin(angle)])
        >>> bool((PanelFlow(nodes, [1.0]).at([3.0]).speed == PanelFlow(nodes, [3.0]).speed).all())
        True
        """
        other = copy(self)
        other._solve(angles)
        return other

    def _solve(self, angles: ArrayLike) -> None:
        self.angles = np.radians(np.atleast_1d(np.asarray(angles, dtype=np.float64)))
        along_x, along_y = self._solutions
        turn = self.angles[:, None]
        self.vorticity = np.cos(turn) * along_x + np.sin(turn) * along_y
        self.speed = 0.5 * (self.vorticity[:, 1:] + self.vorticity[:, :-1])
        if not np.isfinite(self.speed).all():
            raise InputError("the panel method has no solution for this contour")

    @property
    def middles(self) -> Complex:
        """(n,) panel middles."""
        return 0.5 * (self.z[1:] + self.z[:-1])

    @property
    def pressure(self) -> Array:
        """(angles, n) pressure coefficient at the panel middles."""
        result: Array = 1.0 - self.speed**2
        return result

    def lift(self) -> Array:
        """(angles,) lift coefficient from the pressures, chord 1."""
        return (self._turned_force() * np.exp(-1j * self.angles)).imag

    def drag(self) -> Array:
        """(angles,) drag coefficient from the pressures, chord 1.

        There is none in such a flow: what is found tells the error of the panels.
        """
        return (self._turned_force() * np.exp(-1j * self.angles)).real

    def moment(self, about: float = 0.25) -> Array:
        """(angles,) pitching moment about (about, 0), nose-up positive, chord 1."""
        arms = ((self.middles - about).conj() * 1j * self.delta).imag
        result: Array = -(self.pressure * arms).sum(axis=1)
        return result

    def _turned_force(self) -> Complex:
        result: Complex = 1j * (self.pressure * self.delta).sum(axis=1)
        return result

    # ---- derivatives ----------------------------------------------------------------------

    def gradient(
        self,
        pressure: Array | None = None,
        lift: Array | None = None,
        moment: Array | None = None,
        about: float = 0.25,
    ) -> Array:
        """Derivative of a functional by the nodes, from its derivatives by the outputs.

        Parameters
        ----------
        pressure : numpy.ndarray, optional
            (angles, n) derivative of the functional by the pressure coefficients.
        lift, moment : numpy.ndarray, optional
            (angles,) its derivatives by the lift and moment coefficients.

        Returns
        -------
        numpy.ndarray
            (n + 1, 2).
        """
        count = len(self.angles)
        by_pressure = np.zeros((count, len(self.delta))) if pressure is None else pressure.copy()
        by_delta = np.zeros(len(self.delta), dtype=complex)  # holomorphic: df = Re(h dz)
        by_middle = np.zeros(len(self.delta), dtype=complex)
        if lift is not None:
            turn = lift * np.exp(-1j * self.angles)
            by_pressure += (turn[:, None] * 1j * self.delta).imag
            by_delta += (turn[:, None] * self.pressure).sum(axis=0)  # Im(i h) = Re(h)
        if moment is not None:
            arm = (self.middles - about).conj()
            weight = (moment[:, None] * self.pressure).sum(axis=0)
            by_pressure -= moment[:, None] * (arm * 1j * self.delta).imag
            by_delta -= weight * arm
            by_middle -= weight * self.delta.conj()  # Re(conj(dm) delta) = Re(dm conj(delta))
        h = self._through_speed(-2.0 * self.speed * by_pressure)
        h[1:] += by_delta + 0.5 * by_middle
        h[:-1] += -by_delta + 0.5 * by_middle
        return self._real(h)

    def pressure_jacobian(self) -> Array:
        """(angles, n, n + 1, 2) derivative of the pressures by the nodes.

        It needs as many right-hand sides as nodes with the factors that are there, by time
        `JACOBIAN_SOLVES` solves of the flow.
        """
        from scipy.linalg import lu_solve

        n, found = len(self.delta), []
        for k, speed in enumerate(self.speed):
            by_nodes = self._by_nodes(k)
            load = np.concatenate([by_nodes.real, -by_nodes.imag], axis=1)
            if self.sharp:
                load = _shared(load.reshape(n + 2, 2, n + 1)).reshape(n + 2, -1)
            with one_thread():
                vorticity = -lu_solve(self._factors, load, check_finite=False)[: n + 1]
            change = -speed[:, None] * (vorticity[1:] + vorticity[:-1])
            found.append(change.reshape(n, 2, n + 1).transpose(0, 2, 1))
        return np.stack(found)

    def _through_speed(self, by_speed: Array) -> Complex:
        """Holomorphic derivative by the nodes of what depends on the speeds."""
        from scipy.linalg import lu_solve

        n = len(self.delta)
        load = np.zeros((n + 2, len(by_speed)))
        load[1 : n + 1] += 0.5 * by_speed.T
        load[:n] += 0.5 * by_speed.T
        with one_thread():
            adjoint = lu_solve(self._factors, load, trans=1, check_finite=False)
        h = np.zeros(n + 1, dtype=complex)
        for k, multipliers in enumerate(adjoint.T):
            h -= (multipliers[:, None] * self._by_nodes(k)).sum(axis=0)
        return h

    def _by_nodes(self, k: int) -> Complex:
        """(n + 2, n + 1) holomorphic derivatives of the equations at an angle by the nodes."""
        n, stream = len(self.delta), np.exp(-1j * self.angles[k])
        parts = np.zeros((2, n + 2, n + 1))
        kernels()[1](
            *self._xy, self.sharp, self.vorticity[k], self._logs, self._turns, *parts
        )  # fmt: skip
        found: Complex = parts[0] + 1j * parts[1]
        found[np.arange(n + 1), np.arange(n + 1)] -= 1j * stream
        self._edge.differentiate(found, self.vorticity[k], stream)
        return found

    def _real(self, h: Complex) -> Array:
        found = np.stack([h.real, -h.imag])
        return (_shared(found) if self.sharp else found).T


def _shared(by_nodes: Array) -> Array:
    """Derivatives by the two nodes of a sharp trailing edge, which count as one in the middle."""
    both = 0.5 * (by_nodes[..., 0] + by_nodes[..., -1])
    by_nodes[..., 0], by_nodes[..., -1] = both, both
    return by_nodes


@cache
def _controller() -> Any:
    from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

    return ThreadpoolController()


def one_thread() -> AbstractContextManager[Any]:
    """BLAS and LAPACK on one thread within."""
    found: AbstractContextManager[Any] = _controller().limit(limits=1, user_api="blas")
    return found


class _Memory(threading.local):
    """Flows about the last few contours: each thread's own, so that a study's depend on it alone.

    What the window has solved about the same contour is no part of a study's counts.
    """

    def __init__(self) -> None:
        self.flows: OrderedDict[bytes, dict[tuple[float, ...], PanelFlow]] = OrderedDict()


_memory = _Memory()


def flow_about(nodes: ArrayLike, angles: tuple[float, ...]) -> PanelFlow:
    """Like `PanelFlow`, but the flows about the last few contours are remembered.

    A cost and its constraints ask for the same flow one after the other, or for one at another
    angle that has the same factors.
    """
    xy = np.ascontiguousarray(nodes, dtype=np.float64)
    flows, key = _memory.flows, xy.tobytes()
    known = flows.setdefault(key, {})
    flows.move_to_end(key)
    while len(flows) > REMEMBERED:
        flows.popitem(last=False)
    if angles not in known:
        first = next(iter(known.values()), None)
        known[angles] = PanelFlow(xy, angles) if first is None else first.at(angles)
    return known[angles]


def is_solved(nodes: ArrayLike) -> bool:
    """Whether the flow about a contour is remembered: asking for it costs nothing."""
    return np.ascontiguousarray(nodes, dtype=np.float64).tobytes() in _memory.flows


def forget_flows() -> None:
    """Begin afresh: two runs of a study give the same bits, whatever was solved before."""
    _memory.flows.clear()


def _complex(nodes: ArrayLike) -> Complex:
    xy = np.asarray(nodes, dtype=np.float64)
    if xy.ndim != 2 or xy.shape[1] < 2 or len(xy) < 5:
        raise InputError(f"the panel method needs at least 5 nodes (n, 2), got {xy.shape}")
    z = xy[:, 0] + 1j * xy[:, 1]
    if not np.isfinite(z).all() or (np.diff(z) == 0).any():
        raise InputError("the panel method needs finite nodes, neighbours apart")
    return z
