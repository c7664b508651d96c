"""Compiled loops of the panel method over all pairs of a node and a panel.

Notation of `influence`: a panel from a to b = a + d with vorticity from p to q, a node z,
u = z - a, v = z - b, t = u / d, I = log(u / v). Its stream function at z is
``-|d| / (2 pi) Re(p L0 + (q - p) L1)`` with

    L0 = t I + log v - 1,    L1 = (log v + t^2 I - t - 1/2) / 2,

the integrals of log(z - s) and of s log(z - s) along the panel (s from 0 to 1). At its own ends
they are log |d| - 1, and log |d| / 2 - 1/4 at a or - 3/4 at b.

One thread and no BLAS: the same bits whatever else the machine does.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ffdstudio.compiling import compiled


@cache
def kernels() -> tuple[Any, Any]:
    """`influence` and `derivatives`, compiled on first use."""
    return compiled(influence), compiled(derivatives)


def influence(x: Any, y: Any, closed: bool, matrix: Any, logs: Any, turns: Any) -> None:
    """Stream function at each node by unit vorticity at each node.

    Parameters
    ----------
    x, y : numpy.ndarray
        (n + 1,) nodes; of a closed contour the last is the first.
    closed : bool
    matrix : numpy.ndarray
        (n + 2, n + 2), zero, is filled but for the last row and column.
    logs : numpy.ndarray
        (n + 1, n + 1) gets log |z_i - z_j|, 0 where they coincide.
    turns : numpy.ndarray
        (n + 1, n + 1) gets in column j < n the angle that panel j spans seen from node i.
    """
    n = len(x) - 1
    for i in range(n + 1):
        logs[i, i] = turns[i, i] = 0.0
        for j in range(i):
            dx, dy = x[i] - x[j], y[i] - y[j]
            square = dx * dx + dy * dy
            logs[i, j] = logs[j, i] = 0.5 * np.log(square) if square > 0 else 0.0
            turns[i, j] = way = np.arctan2(dy, dx)
            turns[j, i] = way - np.pi if way > 0 else way + np.pi
    for i in range(n + 1):
        for j in range(n):
            turn = turns[i, j] - turns[i, j + 1]
            if turn > np.pi:
                turn -= 2 * np.pi
            elif turn < -np.pi:
                turn += 2 * np.pi
            turns[i, j] = turn
    first, zero = np.empty(n), np.empty(n)
    for i in range(n + 1):
        for j in range(n):
            dx, dy = x[j + 1] - x[j], y[j + 1] - y[j]
            square = dx * dx + dy * dy
            ux, uy = x[i] - x[j], y[i] - y[j]
            t, s = (ux * dx + uy * dy) / square, (uy * dx - ux * dy) / square
            behind = logs[i, j + 1]
            log, turn = logs[i, j] - behind, turns[i, j]
            along, across = t * log - s * turn, t * turn + s * log
            zero[j] = along + behind - 1
            first[j] = 0.5 * (behind + t * along - s * across - t - 0.5)
        for j in (i - 1, i, 0, n - 1):
            begins = j == i or (closed and i == n and j == 0)
            if 0 <= j < n and (begins or j == i - 1 or (closed and i == 0 and j == n - 1)):
                zero[j] = logs[j, j + 1] - 1
                first[j] = 0.5 * logs[j, j + 1] - (0.25 if begins else 0.75)
        for j in range(n):
            scale = -np.hypot(x[j + 1] - x[j], y[j + 1] - y[j]) / (2 * np.pi)
            matrix[i, j] += scale * (zero[j] - first[j])
            matrix[i, j + 1] += scale * first[j]


def derivatives(
    x: Any, y: Any, closed: bool, vorticity: Any, logs: Any, turns: Any, real: Any, imag: Any
) -> None:
    """Derivatives of the stream function at each node by the nodes, at given vorticities.

    ``h = real[i, k] + 1j * imag[i, k]`` is such that the stream function at node i changes by
    Re(h dz_k). All parts of a row are made in one loop that the compiler turns into vector
    instructions; panels that end at the node are put right afterwards.
    """
    n = len(x) - 1
    invx, invy, awayx, awayy, own = np.empty((5, n))
    for j in range(n):
        dx, dy, own[j] = x[j + 1] - x[j], y[j + 1] - y[j], logs[j, j + 1]
        square = dx * dx + dy * dy
        invx[j], invy[j] = dx / square, -dy / square  # 1 / d
        size = np.sqrt(square) / (2 * np.pi)
        awayx[j], awayy[j] = -size * invx[j], -size * invy[j]  # |d| / d = conj(d) / |d|
    ux, uy, vx, vy, part = np.empty((5, n))
    for i in range(n + 1):
        for j in range(n):
            p, e = vorticity[j], vorticity[j + 1] - vorticity[j]
            dx, dy = x[i] - x[j], y[i] - y[j]
            t, s = dx * invx[j] - dy * invy[j], dx * invy[j] + dy * invx[j]
            behind = logs[i, j + 1]
            log, turn = logs[i, j] - behind, turns[i, j]
            along, across = t * log - s * turn, t * turn + s * log
            twice, beside = t * along - s * across, t * across + s * along  # t^2 I
            part[j] = p * (along + behind - 1) + 0.5 * e * (behind + twice - t - 0.5)
            ux[j] = p * (log - along + 1) + e * (t - 0.5 - twice + along)
            uy[j] = p * (turn - across) + e * (s - beside + across)
            vx[j] = p * (along - 1) + e * (twice - 0.5 - t)
            vy[j] = p * across + e * (beside - s)
        for j in (i - 1, i, 0, n - 1):
            begins = j == i or (closed and i == n and j == 0)
            if 0 <= j < n and (begins or j == i - 1 or (closed and i == 0 and j == n - 1)):
                p, e = vorticity[j], vorticity[j + 1] - vorticity[j]
                part[j] = p * own[j] + e * (0.5 * own[j] + (0.25 if begins else -0.25))
                ux[j] = uy[j] = vx[j] = vy[j] = 0.0
        herex = herey = 0.0
        for j in range(n):
            sumx, sumy = ux[j] + vx[j], uy[j] + vy[j]
            herex += awayx[j] * sumx - awayy[j] * sumy
            herey += awayx[j] * sumy + awayy[j] * sumx
        for j in range(n):
            endx, endy = ux[j] + part[j], uy[j]
            real[i, j] -= awayx[j] * endx - awayy[j] * endy
            imag[i, j] -= awayx[j] * endy + awayy[j] * endx
        for j in range(n):
            endx, endy = part[j] - vx[j], -vy[j]
            real[i, j + 1] += awayx[j] * endx - awayy[j] * endy
            imag[i, j + 1] += awayx[j] * endy + awayy[j] * endx
        real[i, i] += herex
        imag[i, i] += herey
