"""A volume follows its surface: against the formula summed one by one, and what must not break."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ffdstudio import threads
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, inverted, quality, read_mesh
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.following import Follower, field, moved_boundaries
from ffdstudio.samples import sample

RNG = np.random.default_rng(5)


def box(
    cells=(6, 5, 4),
    lower=(0.0, 0.0, 0.0),
    upper=(3.0, 2.0, 1.5),
    kinds=None,
    partners=None,
    twice=False,
):
    """Bricks with a marker on each side: x0, x1, y0, ..."""
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(lower, upper, cells, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    number = np.arange(len(grid)).reshape([n + 1 for n in cells])
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    bricks = [
        [number[i + a, j + b, k + c] for c in (0, 1) for a, b in square]
        for i, j, k in np.ndindex(*cells)
    ]
    markers = {}
    for axis in range(3):
        for side in (0, 1):
            layer = np.take(number, -side, axis=axis)
            shape = np.array(layer.shape) - 1
            quads = [[layer[j + a, k + b] for a, b in square] for j, k in np.ndindex(*shape)]
            markers[f"{'xyz'[axis]}{side}"] = {"quad": quads}
    return Mesh(grid, {"hexahedron": bricks}, markers, kinds=kinds or {}, partners=partners or {})


def hill(mesh, marker="z0", height=0.4, centre=(1.4, 0.9)):
    """Displacements of a floor: a smooth hill."""
    x = mesh.points[mesh.marker_nodes(marker)]
    square = ((x[:, :2] - centre) ** 2).sum(axis=1)
    return height * np.exp(-2 * square)[:, None] * [0.2, 0.1, 1.0]


def airfoil():
    mesh = read_mesh(sample("naca0012.su2"))
    return mesh, mesh.points[mesh.marker_nodes("airfoil")]


def turned(x, degrees, about=(0.25, 0.0, 0.0)):
    turn = Rotation.from_euler("z", degrees, degrees=True).as_matrix()
    return (x - about) @ turn.T + about - x


def summed(mesh, follower, displacements, near):
    """Luke, Collins and Blades' formula with the sources one by one; rotations by SciPy."""
    told = np.concatenate([follower.moving, follower.roles.staying])
    step = np.zeros_like(mesh.points)
    step[follower.moving] = displacements
    after = mesh.points + step
    area, neighbours = np.zeros(len(mesh.points)), {int(i): set() for i in told}
    for nodes in follower.roles.elements:
        for element in nodes:
            p = mesh.points[element]
            size = np.linalg.norm(np.cross(p[2] - p[0], p[3] - p[1])) / 2
            area[element] += size / 4
            for a, b in zip(element, np.roll(element, -1), strict=True):
                neighbours[int(a)].add(int(b))
                neighbours[int(b)].add(int(a))
    out = after.copy()
    free = np.setdiff1d(np.arange(len(mesh.points)), told)
    total, weighted = np.zeros(len(free)), np.zeros((len(free), 3))
    for i in told:
        j = sorted(neighbours[int(i)])
        before, behind = mesh.points[j] - mesh.points[i], after[j] - after[i]
        weights = 1 / (before**2).sum(axis=1)
        turn = Rotation.align_vectors(behind, before, weights)[0].as_matrix()
        away = mesh.points[free] - mesh.points[i]
        d = np.linalg.norm(away, axis=1)
        w = area[i] * (d**-3 + near**2 * d**-5)
        total += w
        weighted += w[:, None] * (away @ turn.T - away + step[i])
    out[free] += weighted / total[:, None]
    return out


def test_it_is_the_formula_summed_one_by_one(monkeypatch):
    monkeypatch.setattr(field, "TOLERANCE", 0.0)
    grid = box()
    whole = Mesh(grid.points, grid.cells, {"floor": grid.markers["z0"]})
    follower = Follower(whole, ["floor"])
    step = hill(grid)
    got = follower(step)
    assert np.abs(got - summed(whole, follower, step, near=1.0)).max() < 1e-12


def test_clusters_change_little(monkeypatch):
    mesh, x = airfoil()
    step = turned(x, 20)
    fast = Follower(mesh, ["airfoil"])(step)
    monkeypatch.setattr(field, "TOLERANCE", 0.0)
    exact = Follower(mesh, ["airfoil"])(step)
    assert 0 < np.abs(fast - exact).max() < 0.02 * np.abs(step).max()


def test_a_rigid_motion_of_all_boundaries_is_one_of_the_volume():
    mesh = box()
    follower = Follower(mesh, list(mesh.markers))
    turn = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
    goal = mesh.points @ turn.T + [1, 2, 3]
    got = follower((goal - mesh.points)[follower.moving])
    assert np.abs(got - goal).max() < 1e-12


@pytest.mark.parametrize("height", [0.037, 0.1])
def test_layers_beside_a_wall_keep_their_height(height):
    mesh, x = airfoil()
    bump = height * np.exp(-(((x[:, 0] - 0.4) / 0.25) ** 2)) * (x[:, 1] > 0)
    follower = Follower(mesh, ["airfoil"])
    points = follower(bump[:, None] * [0, 1, 0])
    report = quality(mesh, points)
    ratio = report.measures["first_layer_ratio"]
    assert not report.inverted.any()
    assert 0.97 < np.nanmin(ratio) <= np.nanmax(ratio) < 1.03


@pytest.mark.parametrize("degrees", [10, 45, 90, 180, -150])
def test_a_section_turns_as_far_as_you_like(degrees):
    mesh, x = airfoil()
    follower = Follower(mesh)
    points = follower(turned(x, degrees))
    report = quality(mesh, points)
    ratio = report.measures["first_layer_ratio"]
    assert not report.inverted.any()
    assert 0.99 < np.nanmin(ratio) <= np.nanmax(ratio) < 1.01


def test_told_nodes_are_where_they_were_told_to_be_to_the_bit():
    mesh, x = airfoil()
    follower = Follower(mesh)
    for degrees in (7, 100):
        step = turned(x, degrees)
        points = follower(step)
        assert np.array_equal(points[follower.moving], mesh.points[follower.moving] + step)
        far = mesh.marker_nodes("farfield")
        assert np.array_equal(points[far], mesh.points[far])


def test_no_displacement_is_no_motion_to_the_bit():
    mesh, x = airfoil()
    points = Follower(mesh)(np.zeros_like(x))
    assert points.tobytes() == mesh.points.tobytes()


def test_bits_do_not_depend_on_the_number_of_cores(monkeypatch):
    mesh, x = airfoil()
    monkeypatch.setattr(field, "PIECE", 8)
    found = []
    for cores in (1, 3):
        monkeypatch.setattr(threads, "count", lambda cores=cores: cores)
        threads._pool.cache_clear()
        follower = Follower(mesh)
        step = turned(x, 8)
        found.append((follower(step), follower.pull(mesh.points, step)))
    threads._pool.cache_clear()
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])


def test_half_a_mesh_with_a_symmetry_plane_moves_like_the_whole(monkeypatch):
    monkeypatch.setattr(field, "TOLERANCE", 0.0)
    whole, half = (
        box((5, 8, 4), (0, -1.4, 0), (3, 1.4, 1.5)),
        box((5, 4, 4), (0, 0, 0), (3, 1.4, 1.5)),
    )
    whole = Mesh(whole.points, whole.cells, {"z0": whole.markers["z0"]})  # all other sides stay
    markers = {name: half.markers[name] for name in ("z0", "y0")}
    half = Mesh(half.points, half.cells, markers, kinds={"y0": "symmetry"})
    step = {}
    for name, mesh in (("whole", whole), ("half", half)):
        x = mesh.points[mesh.marker_nodes("z0")]
        rise = 0.3 * np.exp(-((x[:, 0] - 1.5) ** 2) - x[:, 1] ** 2)
        edge = (x[:, 0] % 3 == 0) | (np.abs(x[:, 1]) == 1.4)
        step[name] = np.where(edge, 0, rise)[:, None] * [0.3, 0, 1]
    bent = {
        "whole": Follower(whole, ["z0"])(step["whole"]),
        "half": Follower(half, ["z0"])(step["half"]),
    }
    same = whole.points[:, 1] >= 0
    assert np.abs(bent["whole"][same] - bent["half"]).max() < 1e-10
    plane = half.marker_nodes("y0")
    assert (bent["half"][plane, 1] == 0).all()
    assert np.abs(bent["half"][plane] - half.points[plane])[:, [0, 2]].max() > 0.1


def test_nodes_slide_in_flat_boundaries_that_touch_the_moving_one():
    mesh = box()
    follower = Follower(mesh, ["z0"])
    points = follower(hill(mesh))
    for name, axis in (("x0", 0), ("x1", 0), ("y0", 1), ("y1", 1)):
        nodes = np.setdiff1d(mesh.marker_nodes(name), follower.moving)
        assert np.array_equal(points[nodes, axis], mesh.points[nodes, axis])
        assert (points[nodes] != mesh.points[nodes]).any()
    top = mesh.marker_nodes("z1")
    assert np.array_equal(points[top], mesh.points[top])
    assert inverted(mesh, points).count == 0


def test_a_node_of_two_planes_stays_on_their_line():
    turn = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    flat = box(kinds={"x0": "symmetry", "y0": "symmetry"})
    mesh = Mesh(flat.points @ turn.T, flat.cells, flat.markers, kinds=flat.kinds)
    follower = Follower(mesh, ["z1"])
    points = follower(0.2 * np.ones((len(follower.moving), 1)) * [0, 0, 1.0])
    edge = np.intersect1d(mesh.marker_nodes("x0"), mesh.marker_nodes("y0"))
    step = points[edge] - mesh.points[edge]
    assert np.abs(step[:, :2]).max() < 1e-15
    assert step[:, 2].max() > 0.1


def test_periodic_partners_move_alike():
    mesh = box(kinds={"x0": "periodic", "x1": "periodic"}, partners={"x0": "x1"})
    follower = Follower(mesh, ["z0"])
    x = mesh.points[follower.moving]
    wave = 0.2 * np.sin(2 * np.pi * x[:, 0] / 3 + 1)
    points = follower(wave[:, None] * [0, 0, 1])
    assert broken(mesh, points) == []
    step = points - mesh.points
    a, b = (np.setdiff1d(mesh.marker_nodes(n), mesh.marker_nodes("z0", "z1")) for n in ("x0", "x1"))
    assert np.abs(step[a]).max() > 0.02
    assert np.abs(step[a] - step[b]).max() < 1e-15
    shifted = mesh.points[:, 0] == 1.5  # and feel no edge: half a period further the wave is -wave
    assert np.sign(step[a, 2]).sum() * np.sign(step[shifted][:, 2].sum()) < 0


def test_one_layer_between_empty_planes_is_a_plane_problem():
    layer = box((6, 1, 4), kinds={"y0": "empty", "y1": "empty"})
    follower = Follower(layer, ["z0"])
    x = layer.points[follower.moving]
    points = follower(0.3 * np.exp(-((x[:, 0] - 1.5) ** 2))[:, None] * [0.3, 0, 1])
    assert broken(layer, points) == []
    assert np.array_equal(points[:, 1], layer.points[:, 1])
    step = points - layer.points
    front = layer.points[:, 1] == 0
    assert np.array_equal(step[front], step[~front])
    turn = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])
    corners = layer.cells["hexahedron"][:, [0, 1, 5, 4]]
    number = np.cumsum(front) - 1
    plane = Mesh(
        (layer.points @ turn.T)[front] * [1, 1, 0],
        {"quad": number[corners]},
        {
            name: {"line": number[layer.markers[name]["quad"][:, columns]]}
            for name, columns in (("z0", [0, 1]), ("z1", [0, 1]), ("x0", [0, 3]), ("x1", [0, 3]))
        },
        dimension=2,
    )
    flat = Follower(plane, ["z0"])
    again = flat((step @ turn.T)[front][flat.moving])
    assert np.abs(again - (points @ turn.T)[front] * [1, 1, 0]).max() < 2e-3


def test_nodes_that_a_file_has_twice_stay_together():
    mesh = box((6, 2, 4))
    both = mesh.points[:, 0] == 1.5
    twin = np.arange(len(mesh.points))
    twin[both] = len(mesh.points) + np.arange(both.sum())
    cells = mesh.cells["hexahedron"].copy()
    right = mesh.points[cells][:, :, 0].mean(axis=1) > 1.5
    cells[right] = twin[cells[right]]
    markers = {k: mesh.markers[k] for k in ("z0", "z1", "x0", "x1")}
    floor = markers["z0"]["quad"].copy()
    side = mesh.points[floor][:, :, 0].mean(axis=1) > 1.5
    floor[side] = twin[floor[side]]
    points = np.concatenate([mesh.points, mesh.points[both]])
    split = Mesh(points, {"hexahedron": cells}, {**markers, "z0": {"quad": floor}})
    follower = Follower(split, ["z0"])
    x = split.points[follower.moving]
    step = 0.3 * np.exp(-((x[:, 0] - 1.5) ** 2))[:, None] * [0.1, 0, 1]
    moved = follower(step)
    assert np.array_equal(moved[: -both.sum()][both], moved[-both.sum() :])
    assert (moved[-both.sum() :] != split.points[-both.sum() :]).any()


def differences(follower, step, cost, h=1e-6):
    out = np.zeros_like(step)
    for k in np.ndindex(*step.shape):
        for sign in (1, -1):
            moved = step.copy()
            moved[k] += sign * h
            out[k] += sign * cost(follower(moved)) / (2 * h)
    return out


@pytest.mark.parametrize("case", ["planes", "periodic", "empty", "free"])
def test_sensitivities_are_pulled_to_the_surface(case):
    kinds = {
        "planes": {"x0": "symmetry", "y0": "symmetry"},
        "periodic": {"x0": "periodic", "x1": "periodic"},
        "empty": {"y0": "empty", "y1": "empty"},
        "free": {},
    }[case]
    cells = (3, 1, 3) if case == "empty" else (3, 2, 3)
    mesh = box(cells, kinds=kinds)
    follower = Follower(mesh, ["z0"])
    step = hill(mesh) * ([1, 0, 1] if case == "empty" else 1)
    gradient = np.random.default_rng(2).normal(size=mesh.points.shape)
    got = follower.pull(gradient, step)
    want = differences(follower, step, lambda points: (gradient * points).sum())
    if case == "empty":  # of the two nodes at a place in the plane the first is the source
        got, want = got[:, [0, 2]], want[:, [0, 2]]
    assert np.abs(got - want).max() < 1e-7 * np.abs(want).max()


def test_sensitivities_in_a_plane_mesh():
    mesh, x = airfoil()
    follower = Follower(mesh)
    step = turned(x, 5) + 0.02 * np.sin(9 * x[:, :1]) * [0, 1, 0]
    gradient = np.random.default_rng(3).normal(size=mesh.points.shape)
    direction = RNG.normal(size=step.shape) * [1e-3, 1e-3, 0]
    got = (follower.pull(gradient, step) * direction).sum()
    h = 1e-4
    want = (gradient * (follower(step + h * direction) - follower(step - h * direction))).sum()
    assert got == pytest.approx(want / (2 * h), rel=1e-6)


def test_planes_and_flat_neighbours_are_no_moving_walls():
    mesh = box(kinds={"x0": "symmetry"})
    bent = Mesh(
        mesh.points + 0.1 * np.sin(mesh.points[:, :1]) * [0, 0, 1] * (mesh.points[:, 2:] == 0),
        mesh.cells, mesh.markers, kinds=mesh.kinds,
    )  # fmt: skip
    step = np.where(bent.points[:, 2:] < 0.2, 1.0, 0.0) * [0, 0, 0.1]
    assert moved_boundaries(bent, step) == ("z0",)
    step[bent.marker_nodes("y1")] *= [0, 2, 1]
    step[bent.marker_nodes("y1"), 1] = step[bent.marker_nodes("y1"), 2]
    assert moved_boundaries(bent, step) == ("y1", "z0")


@pytest.mark.parametrize(
    ("moving", "cause"), [(["hull"], "no marker hull"), ([], "no walls"), ([10**9], "indices")]
)
def test_what_cannot_move_is_refused(moving, cause):
    with pytest.raises(InputError, match=cause):
        Follower(box(), moving)


def test_a_surface_has_no_volume_to_follow():
    triangle = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 1]], {"triangle": [[0, 1, 2]]})
    with pytest.raises(InputError, match="no volume"):
        Follower(triangle, [0])


def test_displacements_that_do_not_fit_are_refused():
    follower = Follower(box(), ["z0"])
    with pytest.raises(InputError, match=r"42 nodes move.*\(3, 3\)"):
        follower(np.zeros((3, 3)))
    with pytest.raises(InputError, match="not a finite number"):
        follower(np.full((42, 3), np.nan))
    with pytest.raises(InputError, match="sensitivities are of shape"):
        follower.pull(np.zeros((2, 3)), np.zeros((42, 3)))


def test_a_derivative_across_steps_is_refused():
    mesh, x = airfoil()
    with pytest.raises(InputError, match="over 60 degrees"):
        Follower(mesh).pull(mesh.points, turned(x, 90))


def test_it_tells_how_far_it_is_and_can_be_stopped():
    mesh, x = airfoil()
    heard = []
    Follower(mesh)(turned(x, 90), lambda share, text: heard.append((share, text)))
    assert heard[-1] == (0.75, "the volume follows: step 2 of 2")

    def stop(share, text):
        raise RuntimeError(text)

    with pytest.raises(RuntimeError):
        Follower(mesh)(turned(x, 90), stop)
