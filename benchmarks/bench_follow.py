"""A volume that follows its surface against other ways, on the motions that people ask for.

Columns: inverted cells; least and largest height of a first-layer cell over its height at rest;
non-orthogonality, 99.9th percentile in degrees; set-up and evaluation in seconds. Rivals: the
volume carried by the lattice (where the motion is a lattice's), SciPy's radial basis functions
(thin plates, the 64 nearest sources), and PyGeM's inverse distance weighting if its source is
found (`PYGEM=/path/to/PyGeM`).

The last lines: a wing of a million nodes (`--million`, 3 GB), against one deformation by a
lattice of the same nodes.

usage: bench_follow.py [FOLDER WITH su2/mesh_RAE2822_turb_ffd.su2 and wing/oneram6_tets.su2]
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import ffdstudio as ffd
from ffdstudio.meshes import Mesh, quality
from ffdstudio.samples import sample

Case = tuple[str, Mesh, str, np.ndarray, np.ndarray | None]


def lattice_bump(mesh: Mesh, wall: str, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of the wall by a lattice around a section, and of all nodes."""
    nodes = mesh.marker_nodes(wall)
    low, high = mesh.points[nodes].min(axis=0), mesh.points[nodes].max(axis=0)
    room = np.array([0.3, 0.36, 0.0])
    lattice = ffd.Lattice.box((low - room)[:2], (high + room)[:2], (9, 5), (3, 3))
    points = lattice.control_points.copy()
    points[3:6, 3, 1] += [0.5, 1.0, 0.3]
    step = ffd.embed(lattice, mesh.points).deform(lattice.moved(points)) - mesh.points
    step *= height / np.linalg.norm(step[nodes], axis=1).max()
    return step[nodes], step


def turned(mesh: Mesh, wall: str, degrees: float) -> np.ndarray:
    """Displacements of a section that turns about its quarter chord."""
    x, t = mesh.points[mesh.marker_nodes(wall)] - [0.25, 0, 0], np.radians(degrees)
    return x @ np.array([[np.cos(t), np.sin(t), 0], [-np.sin(t), np.cos(t), 0], [0, 0, 1]]) - x


def bump(mesh: Mesh, wall: str, height: float) -> np.ndarray:
    """Displacements of the upper side by a bump."""
    x = mesh.points[mesh.marker_nodes(wall)]
    rise = height * np.exp(-(((x[:, 0] - 0.5) / 0.25) ** 2)) * (1 - (2 * x[:, 0] - 1) ** 8).clip(0)
    return np.where(x[:, 1] >= 0, rise, 0.0)[:, None] * [0, 1, 0]


def bent(mesh: Mesh, wall: str, share: float) -> np.ndarray:
    """Displacements of a wing whose tip rises by a share of the span (y)."""
    x = mesh.points[mesh.marker_nodes(wall)]
    span = x[:, 1].max()
    return share * span * ((x[:, 1] / span) ** 2)[:, None] * [0, 0, 1]


def cases(folder: Path | None) -> Iterator[Case]:
    """Motions of walls, and of all nodes where a lattice makes them."""
    sections = [(ffd.read_mesh(sample("naca0012.su2")), "airfoil", "NACA 0012")]
    wings = [(ffd.read_mesh(sample("wing_air.su2")), "WING", "wing")]
    if folder is not None:
        rae = folder / "su2" / "mesh_RAE2822_turb_ffd.su2"
        sections.insert(0, (ffd.read_mesh(rae), "AIRFOIL", "RAE 2822"))
        wings.insert(0, (ffd.read_mesh(folder / "wing" / "oneram6_tets.su2"), "WING", "M6"))
    for mesh, wall, name in sections:
        step, whole = lattice_bump(mesh, wall, 0.037)
        yield f"{name}, skin by 0.037", mesh, wall, step, whole
        yield f"{name}, 10 degrees", mesh, wall, turned(mesh, wall, 10), None
        yield f"{name}, 90 degrees", mesh, wall, turned(mesh, wall, 90), None
        yield f"{name}, bump of 0.1", mesh, wall, bump(mesh, wall, 0.1), None
    for mesh, wall, name in wings:
        yield f"{name}, bent by 10 %", mesh, wall, bent(mesh, wall, 0.1), None


def judged(mesh: Mesh, points: np.ndarray) -> str:
    """Figures of a deformed mesh."""
    report = quality(mesh, points)
    layer, angle = (report.measures[k] for k in ("first_layer_ratio", "non_orthogonality"))
    return (
        f"{int(report.inverted.sum()):6d} {np.nanmin(layer):8.4f} {np.nanmax(layer):8.4f} "
        f"{np.nanpercentile(angle, 99.9):7.1f}"
    )


def sources(follower: ffd.Follower, step: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places and displacements of all nodes that are told where to go."""
    roles, points = follower.roles, follower.mesh.points
    places = np.concatenate([points[roles.moving], points[roles.staying]])
    return places, np.concatenate([step, np.zeros((len(roles.staying), 3))])


def by_scipy(mesh: Mesh, follower: ffd.Follower, step: np.ndarray) -> np.ndarray:
    """Thin plates through the nearest 64 sources."""
    from scipy.interpolate import RBFInterpolator

    places, moves = sources(follower, step)
    axes = slice(0, mesh.dimension)
    found = RBFInterpolator(places[:, axes], moves, neighbors=64, kernel="thin_plate_spline")
    points = mesh.points + found(mesh.points[:, axes])
    points[follower.moving] = mesh.points[follower.moving] + step
    points[follower.roles.staying] = mesh.points[follower.roles.staying]
    return points


def by_pygem(mesh: Mesh, follower: ffd.Follower, step: np.ndarray) -> np.ndarray:
    """PyGeM's inverse distance weighting, with its default power."""
    from pygem import IDW

    places, moves = sources(follower, step)
    return IDW(places, places + moves)(mesh.points)


def timed(work: Callable[[], np.ndarray]) -> tuple[np.ndarray, float]:
    """What a call returns, and its seconds."""
    begin = time.perf_counter()
    return work(), time.perf_counter() - begin


def table(folder: Path | None) -> None:
    """Print a line for each motion and way."""
    print(f"{'motion':26s} {'way':18s} inverted  least   largest  degrees  set-up s  again s")
    with_pygem = os.environ.get("PYGEM", "")
    sys.path.insert(0, with_pygem)
    for name, mesh, wall, step, whole in cases(folder):
        follower, make = timed(lambda m=mesh, w=wall: ffd.Follower(m, [w]))
        points, first = timed(lambda f=follower, s=step: f(s))
        _, again = timed(lambda f=follower, s=step: f(s))
        print(
            f"{name:26s} {'follows its walls':18s} {judged(mesh, points)} "
            f"{make + first - again:9.3f} {again:8.3f}", flush=True,
        )  # fmt: skip
        if whole is not None:
            print(f"{'':26s} {'lattice carries':18s} {judged(mesh, mesh.points + whole)}")
        ways = [("SciPy RBF", by_scipy)] + ([("PyGeM IDW", by_pygem)] if with_pygem else [])
        for label, way in ways:
            found, seconds = timed(lambda w=way, m=mesh, f=follower, s=step: w(m, f, s))
            print(f"{'':26s} {label:18s} {judged(mesh, found)} {'':9s} {seconds:8.3f}", flush=True)


def wing(around: int, off: int, along: int) -> Mesh:
    """O-grid of hexahedra around a tapered NACA 0012 wing."""
    angle = np.linspace(0, 2 * np.pi, around, endpoint=False)
    x = 0.5 * (1 + np.cos(angle))
    y = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    skin = np.stack([x, np.where(angle < np.pi, y, -y)], 1)
    far = np.stack([0.5 + 8 * np.cos(angle), 8 * np.sin(angle)], 1)
    grow = 1 + 6 / off
    share = (grow ** np.arange(off + 1) - 1) / (grow**off - 1)
    span = np.arange(along + 1) / along
    root = skin * (1 - 0.5 * span)[:, None, None] + 0.3 * span[:, None, None] * [1, 0]
    plane = root[:, None] * (1 - share)[:, None, None] + far * share[:, None, None]
    height = np.broadcast_to(2 * span[:, None, None, None], (*plane.shape[:3], 1))
    points = np.concatenate([plane, height], axis=3).reshape(-1, 3)
    i = np.arange(len(points)).reshape(along + 1, off + 1, around)
    j = np.roll(i, -1, axis=2)
    square = [i[:, :-1], i[:, 1:], j[:, 1:], j[:, :-1]]
    cells = np.stack([s[:-1] for s in square] + [s[1:] for s in square], -1).reshape(-1, 8)
    strip = lambda k: np.stack([i[:-1, k], j[:-1, k], j[1:, k], i[1:, k]], -1).reshape(-1, 4)  # noqa: E731
    side = lambda k: np.stack([s[k] for s in square], -1).reshape(-1, 4)  # noqa: E731
    markers = {
        "WING": {"quad": strip(0)}, "FAR": {"quad": strip(-1)},
        "SYMMETRY": {"quad": side(0)}, "TIP": {"quad": side(-1)},
    }  # fmt: skip
    return Mesh(points, {"hexahedron": cells}, markers)


def million(around: int, off: int, along: int) -> None:
    """Seconds of a large mesh, and the ratio to a lattice's deformation."""
    mesh = wing(around, off, along)
    x = mesh.points[mesh.marker_nodes("WING")]
    step = (0.05 * x[:, 2] ** 2 + 0.02 * np.sin(3 * x[:, 0]))[:, None] * [0, 1, 0]
    box = ffd.Lattice.box((-0.3, -0.4, -0.1), (1.3, 0.4, 2.1), (9, 5, 5))
    moved = box.control_points + 0.01 * np.sin(7 * box.control_points[..., ::-1])
    embedding, embed = timed(lambda: ffd.embed(box, mesh.points))
    follower, make = timed(lambda: ffd.Follower(mesh, ["WING"]))
    points, first = timed(lambda: follower(step))
    again = min(timed(lambda: follower(step))[1] for _ in range(5))
    carried = min(timed(lambda: embedding.deform(box.moved(moved)))[1] for _ in range(5))
    print(f"{len(mesh.points)} nodes: set-up {make + first - again:.2f} s, again {again:.3f} s")
    print(
        f"lattice: embedding {embed:.2f} s, deforming {carried:.4f} s; ratio {again / carried:.0f}"
    )
    print(f"{judged(mesh, points)}  (inverted, least and largest layer, degrees)")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--million", action="store_true")
    args = parser.parse_args()
    table(args.folder)
    million(*((320, 60, 52) if args.million else (120, 30, 16)))


if __name__ == "__main__":
    main()
