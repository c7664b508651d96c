"""Cost of function.toml: how far the camber is from a parabola, and the thickness from 11 %.

A function gets the (n, 3) points, here from the upper trailing edge over the nose to the lower
one, and returns the cost. With ``gradient = true`` it returns (cost, (n, 3) gradient).
"""

import numpy as np


def cost(points):
    """Mean squared gap of the camber, and the squared gap of the largest thickness."""
    upper, lower = points, points[::-1]  # cosine-spaced: pairs at one abscissa
    camber = 0.5 * (upper[:, 1] + lower[:, 1])
    gap = camber - 0.08 * points[:, 0] * (1 - points[:, 0])
    thickness = float((upper[:, 1] - lower[:, 1]).max())
    return float(np.mean(gap**2)) + (thickness - 0.11) ** 2
