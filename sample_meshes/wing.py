"""A tapered swept half wing: its skin, the spars and ribs inside, and the air around it.

1. The skin is a grid: `AROUND` nodes of the section at each of `STATIONS`, so a node of a spar
   or a rib on the skin is an entry of the same array.
2. The boundary of the air is put together here (skin, symmetry plane, half sphere) and handed
   to Gmsh as discrete surfaces, whose nodes stay as they are.
"""

from itertools import pairwise

import airfoil
import filling
import gmsh
import numpy as np
from files import write_su2, write_vtu

ROOT_CHORD, TIP_CHORD, SPAN, SWEEP = 1.0, 0.5, 2.5, np.radians(25)
AROUND, STATIONS = 40, 28
REAR_SPAR, FRONT_SPAR = 6, 14  # nodes of the upper side, counted from the trailing edge
RIB_DISTANCE = 3  # stations from rib to rib
DEPTH = 4  # cells between lower and upper skin
CENTRE, RADIUS, RIM = np.array([1.0, 0.0, 0.0]), 12.0, 8  # half sphere, RIM edges a quarter turn


def size(wall):
    """Size of triangles and tetrahedra by the distance to the wing."""
    return min(0.05 + 0.27 * wall, 3.0)


def write_all(folder):
    """Skin, structure and air, each in its own file."""
    skin, triangles = skin_points(), skin_triangles()
    flat = skin.reshape(-1, 3)
    write_vtu(folder / "wing_skin.vtu", flat, {"triangle": triangles}, "side", sides(triangles))
    write_structure(folder / "wing_structure.vtu", skin)
    write_air(folder / "wing_air.su2", flat, triangles)


def skin_points():
    """(STATIONS, AROUND, 3) nodes: x along the chord, y along the span, z up."""
    y = np.linspace(0, SPAN, STATIONS)[:, None]
    chord = ROOT_CHORD + (TIP_CHORD - ROOT_CHORD) * y / SPAN
    x, z = airfoil.section(AROUND).T
    return np.stack(np.broadcast_arrays(np.tan(SWEEP) * y + chord * x, y, chord * z), axis=-1)


def node(station, i):
    """Number of a skin node; i counts around the section."""
    return station * AROUND + i % AROUND


def skin_triangles():
    """(k, 3) nodes of the upper and lower side, then of the flat tip; normals point outwards."""
    station, i = np.meshgrid(np.arange(STATIONS - 1), np.arange(AROUND), indexing="ij")
    a, b = node(station, i), node(station + 1, i)
    c, d = node(station + 1, i + 1), node(station, i + 1)
    swept = (i < AROUND // 2)[..., None]  # the shorter diagonal, on the upper side that from a to c
    one = np.where(swept, np.stack([a, b, c], -1), np.stack([a, b, d], -1))
    two = np.where(swept, np.stack([a, c, d], -1), np.stack([b, c, d], -1))
    return np.concatenate([one.reshape(-1, 3), two.reshape(-1, 3), tip_triangles()])


def tip_triangles():
    """A strip between the nodes of the upper and of the lower side."""
    j = np.arange(AROUND // 2)
    upper, lower = node(STATIONS - 1, j), node(STATIONS - 1, -j)
    next_upper, next_lower = node(STATIONS - 1, j + 1), node(STATIONS - 1, -j - 1)
    ahead = np.column_stack([upper, next_lower, next_upper])[:-1]
    behind = np.column_stack([upper, lower, next_lower])[1:]
    return np.concatenate([ahead, behind])


def sides(triangles):
    """0 for the wing's surface, 1 for its tip, one number a triangle."""
    return (triangles >= node(STATIONS - 1, 0)).all(axis=1).astype(int)


def write_structure(path, skin):
    """Spars and ribs as quads. Parts: 1 the front spar, 2 the rear spar, 11, 12, ... the ribs."""
    upper = skin[:, REAR_SPAR : FRONT_SPAR + 1]
    lower = skin[:, -np.arange(REAR_SPAR, FRONT_SPAR + 1)]
    height = np.linspace(0, 1, DEPTH + 1)[:, None]
    points = lower[:, :, None] * (1 - height) + upper[:, :, None] * height
    numbers = np.arange(points[..., 0].size).reshape(points.shape[:3])
    parts = {1: quads(numbers[:, -1]), 2: quads(numbers[:, 0])}
    for rib, station in enumerate(range(0, STATIONS, RIB_DISTANCE)):
        parts[11 + rib] = quads(numbers[station])
    points, cells = filling.without_unused(
        points.reshape(-1, 3), {"quad": np.concatenate(list(parts.values()))}
    )
    part = np.repeat(list(parts), [len(block) for block in parts.values()])
    write_vtu(path, points, cells, "part", part)


def quads(numbers):
    """(k, 4) cells of a grid of node numbers."""
    corners = numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]
    return np.stack(corners, axis=-1).reshape(-1, 4)


def write_air(path, skin, wing):
    """Tetrahedra between the wing's triangles, the symmetry plane and a half sphere."""
    sphere, far = half_sphere()
    rim = np.flatnonzero(sphere[:, 1] == 0)
    plane, symmetry = symmetry_plane(skin[:AROUND], sphere[rim])
    numbers = np.concatenate([np.arange(AROUND), len(skin) + rim])
    inner = len(skin) + len(sphere) + np.arange(len(plane) - len(numbers))
    symmetry = np.concatenate([numbers, inner])[symmetry]
    boundary = np.concatenate([skin, sphere, plane[len(numbers) :]])
    markers = {"WING": wing, "SYMMETRY": symmetry, "FARFIELD": far + len(skin)}
    points, tetrahedra = fill(boundary, markers.values(), len(skin))
    elements = {name: {"triangle": triangles} for name, triangles in markers.items()}
    write_su2(path, points, {"tetra": tetrahedra}, elements)


def half_sphere():
    """Points and triangles of the half of a divided octahedron with y >= 0, on the sphere.

    The rim comes first, in order around the y axis.
    """
    quarter = np.pi / 2 / RIM
    points, rows = [], []
    for level in range(RIM + 1):
        count = max(4 * (RIM - level), 1)
        turn, height = 2 * np.pi * np.arange(count) / count, level * quarter
        ring = [
            np.cos(turn) * np.cos(height),
            0 * turn + np.sin(height),
            np.sin(turn) * np.cos(height),
        ]
        rows.append(len(points) + np.arange(count))
        points.extend(np.column_stack(ring) * (1, level > 0, 1))
    triangles = [row for lower, upper in pairwise(rows) for row in belt(lower, upper)]
    return CENTRE + RADIUS * np.array(points), np.array(triangles)


def belt(lower, upper):
    """Triangles between a ring of nodes and the one above, which has one fewer a quarter."""
    step = len(lower) // 4
    for i in range(len(lower)):
        above = i - i // step
        a, b = lower[i], lower[(i + 1) % len(lower)]
        c = upper[above % len(upper)]
        yield a, c, b
        if (i + 1) % step:
            yield b, c, upper[(above + 1) % len(upper)]


def symmetry_plane(section, rim):
    """(n, 3) points, those of `section` and `rim` first, and triangles between the two."""
    with filling.session():
        loops = [filling.polygon(section[:, ::2]), filling.polygon(rim[:, ::2])]
        area = gmsh.model.geo.addPlaneSurface(loops[::-1])
        gmsh.model.geo.synchronize()
        filling.set_sizes(size, section[:, ::2])
        gmsh.model.mesh.generate(2)
        points = np.insert(filling.nodes()[:, :2], 1, 0.0, axis=1)
        points[: len(section) + len(rim)] = np.concatenate([section, rim])
        return points, filling.elements("triangle", area)


def fill(boundary, surfaces, wall_count):
    """Points, those of the boundary first, and tetrahedra inside a closed set of triangles."""
    with filling.session():
        mesh, geo = gmsh.model.mesh, gmsh.model.geo
        tags = [gmsh.model.addDiscreteEntity(2) for _ in surfaces]
        mesh.addNodes(2, tags[0], np.arange(1, len(boundary) + 1), boundary.ravel())
        for tag, triangles in zip(tags, surfaces, strict=True):
            mesh.addElementsByType(tag, 2, [], triangles.ravel() + 1)
        air = geo.addVolume([geo.addSurfaceLoop(tags)])
        geo.synchronize()
        filling.set_sizes(size, boundary[:wall_count])
        mesh.generate(3)
        points, cells = filling.nodes(), {"tetra": filling.elements("tetra", air)}
        if not np.array_equal(points[: len(boundary)], boundary):
            raise SystemExit("Gmsh has moved or renumbered nodes of the boundary")
        points, cells = filling.without_unused(points, cells)
        return points, cells["tetra"]
