"""NACA 0012: its coordinates, and an unstructured mesh with thin layers around it."""

import filling
import gmsh
import numpy as np
from files import write_su2

WALL_NODES = 200
FIRST_LAYER, GROWTH, LAYERS = 2e-4, 1.3, 8
FAN = 7  # cells around the trailing edge
RADIUS = 18.0


def size(wall, edges):
    """Size of triangles by the distance to the wall, and to leading and trailing edge."""
    return min(0.012 + 0.125 * wall, 0.004 + 0.16 * edges)


def thickness(x):
    """Half the thickness of NACA 0012 at chord fractions x, closed at the trailing edge.

    Abbott and von Doenhoff, Theory of Wing Sections, equation 6.2, with -0.1036 for -0.1015.
    """
    series = x * (-0.1260 + x * (-0.3516 + x * (0.2843 - 0.1036 * x)))
    return 0.6 * (0.2969 * np.sqrt(x) + series) * (x < 1)


def section(count):
    """(count, 2) points around the section, from the trailing edge over the upper side.

    Both edges are among them, the trailing edge once; `count` is even. Points are closest at
    the leading edge.
    """
    s = np.abs(1 - 2 * np.arange(count) / count)
    x = 0.35 * (1 - np.cos(np.pi * s)) + 0.3 * s**2
    side = np.where(np.arange(count) <= count // 2, 1.0, -1.0)
    return np.column_stack([x, side * thickness(x)])


def write_coordinates(path):
    """Selig's form: from the trailing edge over the upper side and back."""
    points = section(160)
    rows = [f"{x:.8f} {y:.8f}" for x, y in np.vstack([points, points[:1]])]
    path.write_text("\n".join(["NACA 0012", *rows, ""]).replace("-0.00000000", "0.00000000"))


def write_mesh(path):
    """Layers of quads around the section, triangles from there to the farfield."""
    wall = section(WALL_NODES)
    layers, quads, tips, outer = grow(wall)
    points, triangles, farfield = fill(layers[outer], wall)
    inner = len(layers) + np.arange(len(points) - len(outer))
    numbers = np.concatenate([outer, inner])
    points = np.concatenate([layers, points[len(outer) :]])
    ring = np.arange(len(wall))
    markers = {
        "airfoil": {"line": np.column_stack([ring, np.roll(ring, -1)])},
        "farfield": {"line": numbers[farfield]},
    }
    cells = {"triangle": np.concatenate([tips, numbers[triangles]]), "quad": quads}
    write_su2(path, points, cells, markers)


def grow(wall):
    """Points of wall and layers, quads, triangles at the trailing edge, nodes of the last layer.

    Every node of the wall carries a column of `LAYERS` points along its normal; the trailing
    edge carries a fan of columns, from the lower side's normal round to the upper side's.
    """
    edges = np.roll(wall, -1, axis=0) - wall
    normals = unit(np.column_stack([edges[:, 1], -edges[:, 0]]))
    start, end = np.arctan2(*normals[[-1, 0], ::-1].T)
    turn = np.linspace(start, end, FAN + 1)
    fan = np.column_stack([np.cos(turn), np.sin(turn)])
    feet = np.concatenate([np.arange(len(wall)), np.zeros(FAN, int)])
    outward = np.concatenate([fan[-1:], unit(normals[1:] + normals[:-1]), fan[:-1]])
    heights = FIRST_LAYER * (GROWTH ** np.arange(1, LAYERS + 1) - 1) / (GROWTH - 1)
    columns = wall[feet][:, None] + heights[:, None] * outward[:, None]
    numbers = len(wall) + np.arange(columns[..., 0].size).reshape(-1, LAYERS)
    numbers = np.column_stack([feet, numbers])
    after = np.roll(numbers, -1, axis=0)
    corners = numbers[:, :-1], numbers[:, 1:], after[:, 1:], after[:, :-1]
    cells = np.stack(corners, axis=-1).reshape(-1, 4)
    pointed = cells[:, 0] == cells[:, 3]
    points = np.concatenate([wall, columns.reshape(-1, 2)])
    return points, cells[~pointed], cells[pointed, :3], numbers[:, -1]


def unit(vectors):
    """Vectors of length 1."""
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def fill(hole, wall):
    """(n, 2) points, those of the hole first, triangles, and the lines of the farfield."""
    with filling.session():
        inside = filling.polygon(hole)
        circle = farfield_circle()
        loops = [gmsh.model.geo.addCurveLoop(circle), inside]
        gmsh.model.geo.addPlaneSurface(loops)
        gmsh.model.geo.synchronize()
        filling.set_sizes(size, wall, wall[:: WALL_NODES // 2])
        gmsh.model.mesh.generate(2)
        points = filling.nodes()[:, :2]
        points[: len(hole)] = hole
        triangles, farfield = filling.elements("triangle"), filling.elements("line", *circle)
        points, cells, farfield = filling.without_unused(points, {"triangle": triangles}, farfield)
        return points, cells["triangle"], farfield


def farfield_circle():
    """Tags of four arcs around the section."""
    geo = gmsh.model.geo
    centre = geo.addPoint(0.5, 0, 0)
    directions = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    ends = [geo.addPoint(0.5 + RADIUS * x, RADIUS * y, 0) for x, y in directions]
    return [geo.addCircleArc(a, centre, b) for a, b in zip(ends, ends[1:] + ends[:1], strict=True)]
