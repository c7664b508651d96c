"""Meshes that follow a study: never inverted, felt by the metric, no dearer for the cost."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.meshes import inverted, quality, read_mesh
from ffdstudio.meshes.ways import Way
from ffdstudio.optimize.build.build import build, following_meshes
from ffdstudio.optimize.build.place import Place
from ffdstudio.optimize.followers.body import FollowingMesh
from ffdstudio.optimize.followers.seen import SeenObjective, SeenQuantity
from ffdstudio.optimize.followers.strain import edges_of
from ffdstudio.optimize.followers.task import with_followers
from ffdstudio.optimize.followers.through import ThroughWalls
from ffdstudio.optimize.objectives.base import Evaluation, Objective, Request
from ffdstudio.optimize.objectives.distance import PointDistance
from ffdstudio.optimize.runs.study import Study, Task
from ffdstudio.optimize.spec.codec import from_values
from ffdstudio.optimize.variables.level import EmbeddedBody, Level
from ffdstudio.optimize.variables.metrics import Surface
from ffdstudio.optimize.variables.rules import Rules
from ffdstudio.optimize.variables.space import DesignSpace
from ffdstudio.samples import sample

RAE = str(sample("rae2822.dat"))
AIR = str(sample("naca0012.su2"))
ROOMY = {"shape": [11, 5], "lower": [-0.3, -0.36], "upper": [1.3, 0.36]}
BOTH = pytest.mark.parametrize("follow", ["walls", "lattice"])


def case(objective="contour", method="gauss-newton", lattice=None, frozen=0, **shape):
    tables = {
        "shape": {"source": "naca0012", "points": 121, **shape},
        "lattice": lattice or {"shape": [7, 2]},
        "variables": {"frozen": frozen},
        "objective": {"kind": objective, "target": RAE},
        "method": {"name": method},
        "budget": {"evaluations": 40},
    }
    if objective == "flow":
        tables["objective"]["angles"] = [2.0]
    return built(tables)


def built(tables):
    found = build(from_values(tables), Place(Path(AIR).parent))
    return found.keeping(following_meshes(found))


def counted(found, history):
    """Inverted cells of each iterate, counted anew."""
    [body] = found.task.followers
    return [
        inverted(body.mesh, body.at(history.lattice(k))).count for k in range(len(history.iterates))
    ]


@BOTH
@pytest.mark.parametrize("method", ["gauss-newton", "lbfgs", "minimax"])
def test_no_iterate_turns_a_cell_inside_out(follow, method):
    lattice, frozen = ({"shape": [7, 2]}, 0) if follow == "walls" else (ROOMY, 1)
    found = case(method=method, lattice=lattice, frozen=frozen, mesh=AIR, follow=follow)
    history = found.study.run()
    counts = counted(found, history)
    assert len(counts) > 2
    assert max(counts) == 0
    assert [r.measures["inverted"] for r in history.iterates] == counts


def test_carried_by_a_tight_lattice_the_same_study_does_so():
    plain = case()
    history = plain.study.run()
    body = FollowingMesh.of(read_mesh(AIR), plain.rest)
    counts = [
        inverted(body.mesh, body.at(history.lattice(k))).count for k in range(len(history.iterates))
    ]
    assert max(counts) > 0


def test_following_the_walls_costs_nothing_and_keeps_the_layers():
    plain, found = case(), case(mesh=AIR)
    without, with_mesh = plain.study.run(), found.study.run()
    assert with_mesh.iterates[-1].cost == pytest.approx(without.iterates[-1].cost, rel=1e-9)
    [body] = found.task.followers
    assert body.walls == ("airfoil",)
    points = body.at(with_mesh.lattice(-1))
    layers = quality(body.mesh, points).measures["first_layer_ratio"]
    assert 0.97 < np.nanmin(layers) <= np.nanmax(layers) < 1.03
    assert with_mesh.iterates[-1].measures["layer"] == pytest.approx(np.nanmin(layers))


def test_a_refined_study_keeps_its_mesh(tmp_path):
    tables = {
        "shape": {"source": "naca0012", "points": 121, "mesh": AIR},
        "lattice": {"shape": [5, 2]},
        "objective": {"kind": "contour", "target": RAE},
        "method": {"name": "gauss-newton", "metric": "l2"},
        "refinement": {"variables": 18},
    }
    found = built(tables)
    history = found.study.run()
    assert history.refinements
    assert max(counted(found, history)) == 0


def test_steps_are_cut_where_the_first_cell_inverts():
    found = case(method="lbfgs", lattice=ROOMY, frozen=1, mesh=AIR, follow="lattice")
    [body] = found.task.followers
    rest = found.rest
    points = rest.control_points.copy()
    points[5, 2, 1] += 2.0
    body.begin(rest)
    here, there = body.at(rest), body.at(rest.moved(points))
    share = body.reach(here, there)
    assert 0 < share < 1
    assert body.broken(here + share * (there - here)) == 0
    assert body.broken(here + share / 0.95 * 1.001 * (there - here)) > 0


def test_cells_inverted_when_the_study_begins_do_not_count():
    mesh = read_mesh(AIR)
    lattice = ffd.Lattice.box((-0.3, -0.36), (1.3, 0.36), (7, 5), (3, 3))
    points = lattice.control_points.copy()
    points[3, 2, 1] += 2.5
    bad = lattice.moved(points)
    body = FollowingMesh.of(mesh, lattice)
    assert body.broken(body.at(bad)) > 0
    body.begin(bad)
    assert body.broken(body.at(bad)) == 0


# ---- the metric ------------------------------------------------------------------------------


def test_edges_measure_the_gradient_of_a_linear_displacement():
    n = 6
    grid = np.stack(np.meshgrid(np.linspace(0, 2, n), np.linspace(0, 1, n) ** 2), -1)
    points = np.column_stack([grid.reshape(-1, 2), np.zeros(n * n)])
    i = np.arange(n * n).reshape(n, n)
    quads = np.stack([i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]], -1).reshape(-1, 4)
    edges = edges_of(ffd.Mesh(points, {"quad": quads}, dimension=2))
    rows, nodes = edges.rows(1.0)
    u = 3 * points[nodes, 0] + 4 * points[nodes, 1]
    assert np.sum((rows @ u) ** 2) == pytest.approx(2 * (9 + 16))


def test_sampled_edges_stand_for_all():
    mesh = read_mesh(AIR)
    edges = edges_of(mesh).among(np.abs(mesh.points[:, 0]) < 1)
    few = edges.sampled(2000)
    assert len(few.nodes) < 2300 < len(edges.nodes)
    waves = np.sin(3 * mesh.points[:, :1]) * [1, 0] + mesh.points[:, 1:2] * [0, 1]
    energies = []
    for chosen in (edges, few):
        rows, nodes = chosen.rows(1.0)
        energies.append(np.sum((rows @ waves[nodes]) ** 2, axis=0))
    assert energies[1] == pytest.approx(energies[0], rel=0.1)


def test_the_strain_of_the_air_keeps_whitened_variables_near_the_wall():
    conditions = []
    for share in (0.0, 0.1):
        plain = case(objective="contour", lattice=ROOMY, frozen=1)
        body = FollowingMesh.of(read_mesh(AIR), plain.rest, way=Way.LATTICE)
        task = with_followers(plain.task, [body], share)
        level = Level.first(
            EmbeddedBody(task.embedding, task.surface), DesignSpace.of(plain.rest, task.rules)
        )
        lattices = [level.space.at(level.white.matrix[:, k]) for k in range(level.size)]
        air = max(np.abs(body.at(lat) - body.start).max() for lat in lattices)
        wall = np.abs(level.moves).max()
        conditions.append(air / wall)
    assert conditions[0] > 20 * conditions[1]
    assert conditions[1] < 10


def test_gains_of_new_knots_feel_the_air():
    roomy = {"objective": "flow", "method": "lbfgs", "lattice": ROOMY, "frozen": 1}
    found = case(**roomy, mesh=AIR, follow="lattice")
    assert found.task.surface.strain.shape[1] == len(found.task.embedding.points)
    plain = case(**roomy)
    assert found.task.seen_points == len(plain.task.embedding.points)


# ---- what the cost sees ----------------------------------------------------------------------


class Sum(Objective):
    """Weighted sum of coordinates."""

    def __init__(self, weights):
        self.weights = weights

    def answer(self, request: Request) -> Evaluation:
        return Evaluation(float((self.weights * request.points).sum()), self.weights)


def test_the_cost_sees_its_own_points_alone():
    weights = np.arange(6.0).reshape(2, 3)
    seen = SeenObjective(Sum(weights), 2, 4)
    points = np.arange(12.0).reshape(4, 3)
    found = seen.evaluate(points)
    assert found.value == (weights * points[:2]).sum()
    assert np.array_equal(found.gradient, np.vstack([weights, np.zeros((2, 3))]))
    distance = SeenObjective(PointDistance(points[:2] + 1), 2, 4).evaluate(points)
    assert distance.sensitivity.shape[1] == 12
    with seen.starting() as start:
        assert start(Request(points)).result().value == found.value


def test_quantities_see_their_own_points_alone():
    from ffdstudio.optimize.constraints import Area

    contour = case().task.embedding.points
    inner, seen = Area(), SeenQuantity(Area(), len(contour))
    longer = np.vstack([contour, [[5, 5, 0]]])
    assert seen(longer).values == pytest.approx(inner(contour).values)
    rows = np.asarray(seen(longer).derivatives)
    assert rows.shape == (1, 3 * len(longer))
    assert not rows[:, -3:].any()


def test_a_cost_of_all_nodes_goes_through_the_walls():
    mesh = read_mesh(AIR)
    rest = ffd.Lattice.box((-0.01, -0.08), (1.01, 0.08), (5, 2), (3, 1))
    weights = np.random.default_rng(4).normal(size=mesh.points.shape) * [1, 1, 0]
    nodes = mesh.marker_nodes("airfoil")
    edges = np.column_stack([nodes[:-1], nodes[1:]])
    task = Task(Sum(weights), ffd.embed(rest, mesh.points), Surface.edges(mesh.points, edges))
    body = FollowingMesh.of(mesh, rest)
    found = with_followers(task, [body])
    assert isinstance(found.objective, ThroughWalls)
    move = np.zeros_like(rest.control_points)
    move[2, 1, 1] = 0.05
    h = 1e-5
    at = lambda t: found.embedding.deform(rest.moved(rest.control_points + t * move))  # noqa: E731
    got = (found.objective.evaluate(at(1.0)).gradient * (at(1 + h) - at(1 - h))).sum() / (2 * h)
    cost = lambda t: found.objective.evaluate(at(t)).value  # noqa: E731
    assert got == pytest.approx((cost(1 + h) - cost(1 - h)) / (2 * h), rel=1e-5)
    assert inverted(mesh, body.followed(at(1.0))).count == 0


def test_the_solver_never_gets_a_mesh_turned_inside_out():
    mesh = read_mesh(AIR)
    rest = ffd.Lattice.box((-0.3, -0.36), (1.3, 0.36), (7, 5), (3, 3))
    met = []

    class Far(Objective):
        """Wants the nose five chords up, whatever that does to the mesh."""

        def answer(self, request: Request) -> Evaluation:
            met.append(inverted(mesh, request.points).count)
            up = request.points[:, 1] - 5
            gradient = np.zeros_like(request.points)
            near = np.hypot(mesh.points[:, 0] - 0.5, mesh.points[:, 1]) < 0.2
            gradient[near, 1] = up[near]
            return Evaluation(0.5 * float((up[near] ** 2).sum()), gradient)

    nodes = mesh.marker_nodes("airfoil")
    edges = np.column_stack([nodes[:-1], nodes[1:]])
    task = Task(
        Far(), ffd.embed(rest, mesh.points), Surface.edges(mesh.points, edges), Rules(frozen=1)
    )
    for way in Way:
        met.clear()
        found = with_followers(replace(task), [FollowingMesh.of(mesh, rest, way=way)])
        study = Study(found, "lbfgs", budget=ffd_budget(12))
        history = study.run()
        assert len(met) > 1
        assert max(met) == 0
        assert history.iterates[-1].cost < history.iterates[0].cost


def ffd_budget(evaluations):
    from ffdstudio.optimize.budget import Budget

    return Budget(evaluations)
