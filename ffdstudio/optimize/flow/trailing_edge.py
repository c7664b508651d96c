"""The trailing edge of the panel method: a base that the air leaves, or a sharp edge.

Derivatives are holomorphic: a real f changes by Re(h dz) for each h here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ffdstudio.errors import InputError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
INSIDE = 0.1  # of the shorter panel at the edge: where the air inside is at rest, as in XFOIL


class Bisector(NamedTuple):
    """Direction s that the air leaves in, and what it is made of."""

    s: complex
    upper: complex  # unit vectors along the last panels, both pointing aft
    lower: complex
    size: float  # of their sum

    def differentiate(self, z: Complex, by_s: complex) -> Complex:
        """(n + 1,) derivatives by the nodes of what has the derivative by_s by s."""
        by_sum = _through_unit(self.s, self.size, by_s)
        upper = _through_unit(self.upper, abs(z[0] - z[1]), by_sum)
        lower = _through_unit(self.lower, abs(z[-1] - z[-2]), by_sum)
        h = np.zeros(len(z), dtype=complex)
        h[0] += upper
        h[1] -= upper
        h[-1] += lower
        h[-2] -= lower
        return h


def _through_unit(unit: complex, size: float, by_unit: complex) -> complex:
    """Derivative by w from that by w / |w|."""
    return complex(-1j * (1j * by_unit * unit).real * np.conj(unit) / size)


def bisector(z: Complex) -> Bisector:
    """Bisector of the trailing edge.

    Raises
    ------
    InputError
        If the two sides run against each other.

    Examples
    --------
    >>> complex(bisector(np.array([1 + 0.1j, 0.5 + 0.2j, 0, 0.5 - 0.2j, 1 - 0.1j])).s)
    (1+0j)
    """
    upper, lower = (z[0] - z[1]) / abs(z[0] - z[1]), (z[-1] - z[-2]) / abs(z[-1] - z[-2])
    size = abs(upper + lower)
    if size < 1e-9:
        raise InputError("the panel method has no solution for this contour")
    return Bisector((upper + lower) / size, upper, lower, size)


class Base:
    """Panel across an open trailing edge, from the last node to the first.

    Its source and vorticity are those of a stream with the speed U = (q_n - q_0) / 2 along the
    bisector s. With u = z - z_n, v = z - z_0 its stream function at z is
    ``-U / (2 pi) Re(conj(s) Q)``, Q = u log u - v log v - (z_0 - z_n); the cut of the logarithms
    runs aft, off the section.
    """

    def __init__(self, z: Complex, aft: Bisector) -> None:
        self.z, self.aft = z, aft
        self._front, self._back = _log(z - z[-1], aft.s), _log(z - z[0], aft.s)
        gap = z[0] - z[-1]
        self._q = (z - z[-1]) * self._front - (z - z[0]) * self._back - gap

    def enter(self, matrix: Array, load: Array) -> None:
        """Add what the base contributes to the equations of all nodes."""
        n = len(self.z) - 1
        unit = -(np.conj(self.aft.s) * self._q).real / (2 * np.pi)
        matrix[: n + 1, 0] -= 0.5 * unit
        matrix[: n + 1, n] += 0.5 * unit

    def differentiate(self, by_nodes: Complex, vorticity: Array, stream: complex) -> None:
        """Add its derivatives by the nodes, at given vorticities."""
        n = len(self.z) - 1
        scale = -0.5 * (vorticity[n] - vorticity[0]) / (2 * np.pi)
        along, rows = scale * np.conj(self.aft.s), np.arange(n + 1)
        by_nodes[rows, rows] += along * (self._front - self._back)
        by_nodes[: n + 1, n] -= along * self._front
        by_nodes[: n + 1, 0] += along * self._back
        # Re(conj(s) q) changes with s by Re(conj(q) ds)
        for part, factor in ((1.0, self._q.real), (1j, -self._q.imag)):
            by_nodes[: n + 1] += factor[:, None] * self.aft.differentiate(self.z, scale * part)


def _log(w: Complex, aft: complex) -> Complex:
    """Logarithm with its cut along `aft`, 0 at 0; a constant turn is left out."""
    found = np.zeros(len(w), dtype=complex)
    apart = w != 0
    found[apart] = np.log(-w[apart] / aft)
    return found


class SharpEdge:
    """Equation of the second node of a sharp edge: the air just inside is at rest along s."""

    def __init__(self, z: Complex, aft: Bisector) -> None:
        self.z, self.aft = z, aft
        self._a, self._b, self._d = z[:-1], z[1:], np.diff(z)
        self._length = np.abs(self._d)
        self._shorter = 0 if self._length[0] <= self._length[-1] else len(self._d) - 1
        self.place = z[0] - INSIDE * self._length[self._shorter] * aft.s
        self._t = (self.place - self._a) / self._d
        self._log = np.log((self.place - self._a) / (self.place - self._b))
        self._k = -1j * self._d.conj() / (2 * np.pi * self._length)

    def enter(self, matrix: Array, load: Array) -> None:
        """Put it in the place of the stream function at the last node.

        A panel with vorticity from p to q induces ``k (p I + (q - p) (t I - 1))`` there
        (J. Katz, A. Plotkin, Low-Speed Aerodynamics, section 10.3).
        """
        n, s = len(self._d), self.aft.s
        second = self._k * (self._t * self._log - 1)
        row = np.zeros(n + 2)
        row[:n] += ((self._k * self._log - second) * s).real
        row[1 : n + 1] += (second * s).real
        matrix[n], load[n] = row, (-s.real, -s.imag)

    def differentiate(self, by_nodes: Complex, vorticity: Array, stream: complex) -> None:
        """Put its derivatives by the nodes in the place of those of the last node."""
        n, s = len(self._d), self.aft.s
        p, e = vorticity[:-1], np.diff(vorticity)
        a, b, d, t = self._a, self._b, self._d, self._t
        inner = p * self._log + e * (t * self._log - 1)
        velocity = (self._k * inner).sum() + stream
        # of the inner part by the place and the ends; I changes by du / u - dv / v
        by_log = p + e * t
        u, v = self.place - a, self.place - b
        by_u = by_log / u + e * self._log / d - e * t * self._log / d
        by_v = -by_log / v + e * t * self._log / d
        s_k = s * self._k
        row = np.zeros(n + 1, dtype=complex)
        row[:-1] -= s_k * by_u
        row[1:] -= s_k * by_v
        # k = -i conj(d) / (2 pi |d|) turns against d
        turning = -1j * (-1j * s_k * inner).real / d
        row[1:] += turning
        row[:-1] -= turning
        by_place = (s_k * (by_u + by_v)).sum()
        reach = INSIDE * self._length[self._shorter]
        row[0] += by_place
        row += self.aft.differentiate(self.z, velocity - reach * by_place)
        shorter = -INSIDE * (by_place * s).real * np.conj(d[self._shorter])
        shorter /= self._length[self._shorter]
        row[self._shorter + 1] += shorter
        row[self._shorter] -= shorter
        by_nodes[n] = row
