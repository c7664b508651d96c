"""Inviscid, incompressible flow about an airfoil: linear-vorticity panels, exact adjoint.

1. Points are complex numbers z = x + iy, velocities W = u - iv. A straight panel from a to b
   with vorticity falling from p to q induces W(z) = k [(p + (q - p) t) I - (q - p)], where
   t = (z - a)/(b - a), I = log((z - a)/(z - b)), k = -i conj(b - a)/(2 pi |b - a|): the integral
   of a vortex line (Katz and Plotkin, Low-Speed Aerodynamics, section 10.3), in one expression
   that can be differentiated by z, a and b.
2. No flow through the middle of each panel and the Kutta condition (the vorticities at the two
   trailing-edge nodes cancel) give a square system. All angles of attack share its factors.
3. The speed is the one induced at the panel middles. It is of first order in the panel length
   (Cp of a circle: 0.03 at 200 panels) where the mean vorticity, which equals it in the limit,
   is of second; but the vorticity at a thin trailing edge answers to the last wiggle of the
   nodes, and optimizations on it need twice the solves.
4. The adjoint reuses the factors and differentiates the expression of 1 by the nodes: exact for
   the discrete equations, at the price of about one more solve.
5. Nodes run from the upper trailing edge over the nose to the lower one, so that the outside
   lies to the right of each panel; there I = i pi on the panel itself.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError

Complex = NDArray[np.complex128]
REMEMBERED = 4  # contours


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
    speed : numpy.ndarray
        (angles, n) tangential velocity at the panel middles over the free stream's.

    Raises
    ------
    InputError
        If there are fewer than 4 panels, two neighbouring nodes coincide, or the equations
        have no solution (a contour that crosses itself).

    Examples
    --------
    >>> angle = np.linspace(0, 2 * np.pi, 101)
    >>> circle = PanelFlow(np.column_stack([np.cos(angle), np.sin(angle)]), [0.0])
    >>> bool(abs(circle.pressure.min() + 3) < 0.1)  # Cp = 1 - 4 sin^2
    True
    """

    def __init__(self, nodes: ArrayLike, angles: ArrayLike) -> None:
        from scipy.linalg import lu_factor

        self.z = _complex(nodes)
        self.delta = np.diff(self.z)
        self.tangent = self.delta / np.abs(self.delta)
        self._influence = _influence(self.z)
        through = self.tangent[:, None] * self._influence
        kutta = np.zeros(len(self.z))
        kutta[[0, -1]] = 1.0
        self._factors = lu_factor(np.vstack([through.imag, kutta]), check_finite=False)
        self._along = through.real
        self._solve(angles)

    def at(self, angles: ArrayLike) -> PanelFlow:
        """The flow about the same contour at other angles: nothing is factored again.

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
        from scipy.linalg import lu_solve

        self.angles = np.radians(np.atleast_1d(np.asarray(angles, dtype=np.float64)))
        stream = np.exp(-1j * self.angles)[:, None] * self.tangent
        load = np.column_stack([-stream.imag, np.zeros(len(stream))])
        self.vorticity = lu_solve(self._factors, load.T, check_finite=False).T
        self.speed = stream.real + self.vorticity @ self._along.T
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
            by_delta += turn @ self.pressure  # Im(i h) = Re(h)
        if moment is not None:
            arm, weight = (self.middles - about).conj(), moment @ self.pressure
            by_pressure -= moment[:, None] * (arm * 1j * self.delta).imag
            by_delta -= weight * arm
            by_middle -= weight * self.delta.conj()  # Re(conj(dm) delta) = Re(dm conj(delta))
        h = self._through_speed(-2.0 * self.speed * by_pressure)
        h[1:] += by_delta + 0.5 * by_middle
        h[:-1] += -by_delta + 0.5 * by_middle
        return np.column_stack([h.real, -h.imag])

    def _through_speed(self, by_speed: Array) -> Complex:
        """Adjoint: derivative by the nodes of sum(by_speed * speed), as h in Re(h dz)."""
        from scipy.linalg import lu_solve

        load = -(by_speed @ self._along)
        adjoint = lu_solve(self._factors, load.T, trans=1, check_finite=False).T[:, :-1]
        h = np.zeros(len(self.z), dtype=complex)
        for k, angle in enumerate(self.angles):
            weight = (by_speed[k] - 1j * adjoint[k]) * self.tangent
            velocity = np.exp(-1j * angle) + self._influence @ self.vorticity[k]
            self._differentiate(weight, self.vorticity[k], velocity, h)
        return h

    def _differentiate(self, weight: Complex, gamma: Array, velocity: Complex, h: Complex) -> None:
        """Add the derivative of Re sum_i weight_i W_i by the nodes, tangents turning along."""
        z, a, delta = self.middles[:, None], self.z[:-1], self.delta
        p, jump = gamma[:-1], np.diff(gamma)
        t = (z - a) / delta
        log = _logarithm(z, a, self.z[1:])
        k = _factor(delta)
        linear = p + jump * t
        left, right = weight @ (k * linear / (z - a)), weight @ (k * linear / (z - self.z[1:]))
        shift = k * jump / delta
        plain, tilted = weight @ log * shift, weight @ (log * t) * shift
        at_middle = (k * (linear * (1 / (z - a) - 1 / (z - self.z[1:])) + jump * log / delta)).sum(
            axis=1
        ) * weight
        induced = weight @ (k * (linear * log - jump))
        turning = induced.imag - (weight * velocity).imag
        swing = -1j * turning / delta
        h[:-1] += 0.5 * at_middle - plain + tilted - left - swing
        h[1:] += 0.5 * at_middle - tilted + right + swing


class _Memory(threading.local):
    """Flows about the last few contours: each thread's own, so that a study's depend on it alone.

    Rounding differs with the threads of BLAS: what the window has solved about the same contour
    is not to the bit what a study would solve.
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


def _factor(delta: Complex) -> Complex:
    return -1j * delta.conj() / (2 * np.pi * np.abs(delta))


def _logarithm(z: Complex, a: Complex, b: Complex) -> Complex:
    """log((z - a)/(z - b)) at all middles for all panels, from the outside on a panel itself."""
    ratio = (z - a) / (z - b)
    log = 0.5 * np.log(ratio.real**2 + ratio.imag**2) + 1j * np.angle(ratio)  # 3 times np.log
    np.fill_diagonal(log, 1j * np.pi)
    return log


def _influence(nodes: Complex) -> Any:
    """(n, n + 1) velocity at each panel middle by unit vorticity at each node."""
    a, b, delta = nodes[:-1], nodes[1:], np.diff(nodes)
    z = 0.5 * (a + b)[:, None]
    log, k = _logarithm(z, a, b), _factor(delta)
    second = k * ((z - a) / delta * log - 1)
    influence = np.zeros((len(delta), len(nodes)), dtype=complex)
    influence[:, :-1] = k * log - second
    influence[:, 1:] += second
    return influence
