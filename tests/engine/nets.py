"""Control nets for tests: three curved ones, and a rational cylinder."""

import numpy as np

from ffdstudio.engine import Lattice


def _grid() -> tuple[Lattice, np.ndarray]:
    box = Lattice.box([0, 0, 0], [1, 1, 1], (8, 6, 4), (3, 3, 3))
    return box, np.moveaxis(box.control_points, -1, 0)


def wing() -> Lattice:
    """Swept, tapered, twisted wing box."""
    box, (u, v, w) = _grid()
    chord, twist = 1 - 0.6 * v, -0.3 * v
    x, z = (u - 0.25) * chord, (w - 0.5) * 0.2 * chord
    turned = (
        x * np.cos(twist) + z * np.sin(twist) + 1.6 * v,
        4 * v,
        z * np.cos(twist) - x * np.sin(twist) + 0.1 * v,
    )
    return box.moved(np.stack(turned, axis=-1))


def annulus() -> Lattice:
    """Ring of 300 degrees with a hole."""
    box, (u, v, w) = _grid()
    angle, radius = np.deg2rad(300) * u, 0.5 + 0.5 * v
    return box.moved(np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.4 * w], axis=-1))


def wavy() -> Lattice:
    """Net with waves in every direction."""
    box, (u, v, w) = _grid()
    waves = (
        u + 0.06 * np.sin(5 * v + 3 * w),
        v + 0.06 * np.sin(6 * u),
        0.8 * w + 0.08 * np.sin(7 * u) * np.cos(4 * v),
    )
    return box.moved(np.stack(waves, axis=-1))


CURVED = {"wing": wing, "annulus": annulus, "wavy": wavy}


def quarter_cylinder(inner: float = 1.0, outer: float = 2.0, height: float = 3.0) -> Lattice:
    """Exact quarter of a hollow cylinder: u around, v outwards, w up (The NURBS Book, 7.3)."""
    arc = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    net = np.zeros((3, 2, 2, 3))
    net[..., :2] = arc[:, None, None, :] * np.array([inner, outer])[None, :, None, None]
    net[:, :, 1, 2] = height
    weights = np.ones((3, 2, 2))
    weights[1] = np.sqrt(0.5)
    line = [0, 0, 1, 1]
    return Lattice((2, 1, 1), ([0, 0, 0, 1, 1, 1], line, line), net, weights)


def random_lattice(rng, shape=(6, 5, 4), degrees=(3, 2, 3), weighted=True, spread=0.05) -> Lattice:
    """Box lattice with disturbed points and weights."""
    d = len(shape)
    box = Lattice.box([0, 0, 0], [3, 2, 1], shape, degrees)
    moved = box.control_points + rng.normal(scale=spread, size=(*shape, 3))
    weights = rng.uniform(0.5, 2.0, shape) if weighted else None
    return Lattice(degrees, box.knots, moved, weights, np.eye(3)[:d])
