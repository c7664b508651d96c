"""The loops over the corners of cells, compiled by numba.

Each kernel fills the entries of the rows it is given, without the GIL, so that several threads
share the work.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.meshes.measures.work import compiled


@compiled
def touched(
    chosen: np.ndarray, nodes: np.ndarray, cells: np.ndarray, mask: np.ndarray, out: np.ndarray
) -> None:
    """Set `out` for the cells of these rows that have a node in the mask."""
    for row in chosen:
        for node in nodes[row]:
            if mask[node]:
                out[cells[row]] = True
                break


@compiled
def corner_measures(
    chosen: np.ndarray,
    rows: np.ndarray,
    points: np.ndarray,
    nodes: np.ndarray,
    table: np.ndarray,
    tetrahedra: bool,
    factor: float,
    signs: np.ndarray,
    scaled: np.ndarray,
    flipped: np.ndarray,
) -> None:
    """Scaled Jacobian of the chosen ones of these rows, and whether a corner lost its sign.

    With `tetrahedra` a corner is measured by the largest product of edges at the four nodes of
    its tetrahedron, else by the product of its own edges.
    """
    for j in chosen:
        c = rows[j]
        worst, bad = np.inf, False
        for i in range(len(table)):
            a, b = nodes[c, table[i, 0]], nodes[c, table[i, 1]]
            d, e = nodes[c, table[i, 2]], nodes[c, table[i, 3]]
            x, y, z = points[a, 0], points[a, 1], points[a, 2]
            ux, uy, uz = points[b, 0] - x, points[b, 1] - y, points[b, 2] - z
            vx, vy, vz = points[d, 0] - x, points[d, 1] - y, points[d, 2] - z
            wx, wy, wz = points[e, 0] - x, points[e, 1] - y, points[e, 2] - z
            value = ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx)
            u = ux * ux + uy * uy + uz * uz
            v = vx * vx + vy * vy + vz * vz
            w = wx * wx + wy * wy + wz * wz
            product = u * v * w
            if tetrahedra:
                uv = (ux - vx) ** 2 + (uy - vy) ** 2 + (uz - vz) ** 2
                vw = (vx - wx) ** 2 + (vy - wy) ** 2 + (vz - wz) ** 2
                wu = (wx - ux) ** 2 + (wy - uy) ** 2 + (wz - uz) ** 2
                product = max(max(product, u * uv * wu), max(v * uv * vw, w * vw * wu))
            bad = bad or (signs[c, i] != 0 and value * signs[c, i] <= 0.0)
            worst = min(worst, factor * value / np.sqrt(product) if product > 0.0 else 0.0)
        scaled[j], flipped[j] = worst, bad


@compiled
def bounded(
    chosen: np.ndarray,
    rows: np.ndarray,
    points: np.ndarray,
    nodes: np.ndarray,
    table: np.ndarray,
    doubt: np.ndarray,
) -> None:
    """Whether the mean edges of hexahedra leave it open that the Jacobian changes sign inside.

    The largest deviation from the mean edge is bounded by the root of the sum of squares, in
    one pass; a millionth of the edge covers what cancels in it.
    """
    mean = np.zeros((3, 3))
    for j in chosen:
        c = rows[j]
        least, most = 1.0, 1.0
        for axis in range(3):
            mx, my, mz, square = 0.0, 0.0, 0.0, 0.0
            for e in range(4):
                a, b = nodes[c, table[axis, e, 0]], nodes[c, table[axis, e, 1]]
                x = points[b, 0] - points[a, 0]
                y = points[b, 1] - points[a, 1]
                z = points[b, 2] - points[a, 2]
                mx, my, mz, square = mx + x, my + y, mz + z, square + (x * x + y * y + z * z)
            mx, my, mz = mx / 4, my / 4, mz / 4
            size = mx * mx + my * my + mz * mz
            away = max(square - 4 * size, 0.0) + 1e-12 * square
            size = np.sqrt(size)
            least, most = least * size, most * (size + np.sqrt(away))
            mean[axis, 0], mean[axis, 1], mean[axis, 2] = mx, my, mz
        u, v, w = mean[0], mean[1], mean[2]
        volume = (
            u[0] * (v[1] * w[2] - v[2] * w[1])
            + u[1] * (v[2] * w[0] - v[0] * w[2])
            + u[2] * (v[0] * w[1] - v[1] * w[0])
        )
        doubt[j] = abs(volume) <= most - least
