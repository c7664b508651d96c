"""Plane and periodic boundaries: recognised, and what is told when a deformation breaks them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.meshes.boundary_checks import broken
from ffdstudio.meshes.pairs import pairs_of
from ffdstudio.meshes.planes import planes_of

N = 3


def block(turn: np.ndarray | None = None, names: dict | None = None, kinds: dict | None = None):
    """Unit cube of N^3 hexahedra with a marker on each side: x0, x1, y0, ..."""
    m = N + 1
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, m)] * 3, indexing="ij"), -1).reshape(-1, 3)
    number = np.arange(m**3).reshape(m, m, m)
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    cells = [
        [number[i + a, j + b, k + c] for c in (0, 1) for a, b in square]
        for i, j, k in np.ndindex(N, N, N)
    ]
    markers = {}
    for axis in range(3):
        for side in (0, 1):
            layer = np.take(number, -side, axis=axis)
            quads = [[layer[j + a, k + b] for a, b in square] for j, k in np.ndindex(N, N)]
            name = f"{'xyz'[axis]}{side}"
            markers[(names or {}).get(name, name)] = {"quad": quads}
    points = grid if turn is None else grid @ turn.T + [3, -2, 1]
    return Mesh(points, {"hexahedron": cells}, markers, kinds=kinds or {})


def rotation(seed: int = 0) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]


# ---- planes ---------------------------------------------------------------------------------


def test_a_marker_called_symmetry_is_a_plane_along_an_axis() -> None:
    mesh = block(names={"y0": "SYMMETRY"})
    [plane] = planes_of(mesh)
    assert (plane.name, plane.kind, plane.normal.tolist(), plane.offset) == (
        "SYMMETRY",
        "symmetry",
        [0, 1, 0],
        0.0,
    )
    assert plane.nodes.tolist() == np.flatnonzero(mesh.points[:, 1] == 0).tolist()


def test_the_files_word_counts_and_other_markers_do_not() -> None:
    [plane] = planes_of(block(kinds={"z1": "symmetry", "x0": "wall", "x1": "patch"}))
    assert (plane.name, plane.normal.tolist(), plane.offset) == ("z1", [0, 0, 1], 1.0)
    assert planes_of(block()) == ()


def test_a_turned_plane_is_found_with_its_normal() -> None:
    turn = rotation()
    mesh = block(turn, {"x1": "symm"})
    [plane] = planes_of(mesh)
    assert abs(plane.normal @ turn[:, 0]) == pytest.approx(1, abs=1e-14)
    assert np.abs(plane.distances(mesh.points[plane.nodes])).max() < 1e-14
    assert len(plane.nodes) == (N + 1) ** 2


def test_front_and_back_in_one_marker_are_two_planes() -> None:
    mesh = block(kinds={"ends": "empty"})
    both = np.concatenate([mesh.markers["z0"]["quad"], mesh.markers["z1"]["quad"]])
    markers = {"ends": {"quad": both}, "x0": mesh.markers["x0"]}
    mesh = Mesh(mesh.points, dict(mesh.cells), markers, kinds=mesh.kinds)
    planes = planes_of(mesh)
    assert sorted(plane.offset for plane in planes) == [0, 1]
    assert all(plane.normal.tolist() == [0, 0, 1] for plane in planes)


def test_a_curved_marker_is_no_plane_whatever_its_name() -> None:
    mesh = block(names={"y0": "symmetric_hull"})
    bump = np.zeros_like(mesh.points)
    bump[:, 1] = 1e-4 * np.sin(7 * mesh.points[:, 0] * (1 + mesh.points[:, 2]))
    assert planes_of(mesh.with_points(mesh.points + bump)) == ()


def test_real_files_have_their_planes(shared: Path) -> None:
    wing = read_mesh(shared / "meshes" / "wing" / "oneram6_tets.su2")
    [plane] = planes_of(wing)
    assert (plane.name, len(plane.nodes), plane.normal.tolist()) == ("SYMMETRY", 1287, [0, 1, 0])
    assert abs(plane.offset) < 1e-10
    channel = read_mesh(shared / "meshes" / "cgns" / "mesh_bend_coarse.cgns")
    assert sorted(plane.offset for plane in planes_of(channel)) == [0, 1]
    liner = read_mesh(shared / "meshes" / "cgns" / "717_wl_L2.cgns")
    assert {plane.name for plane in planes_of(liner)} == {"Sym"}
    foil = read_mesh(shared / "meshes" / "openfoam" / "airFoil2D")
    assert sorted(plane.offset for plane in planes_of(foil)) == pytest.approx([0, 0.05])
    [pair] = pairs_of(foil)
    assert pair.opposite
    assert len(pair.first) == len(foil.points) // 2


# ---- what is told ---------------------------------------------------------------------------


def test_motion_in_the_plane_breaks_nothing_and_motion_across_is_measured() -> None:
    mesh = block(rotation(), {"x1": "symm"})
    [plane] = planes_of(mesh)
    across = np.sin(np.arange(len(mesh.points)))[:, None] * plane.normal
    slide = np.random.default_rng(1).standard_normal(mesh.points.shape)
    slide -= np.outer(slide @ plane.normal, plane.normal)
    assert broken(mesh, mesh.points + slide) == []
    step = np.abs(np.sin(plane.nodes))
    [sentence] = broken(mesh, mesh.points + slide + across)
    bad = int((step > 0).sum())
    assert sentence.startswith(f"symm is no longer planar: {bad} of 16 nodes leave it, by up to")
    assert float(sentence.split()[-1]) == pytest.approx(step.max(), rel=1e-2)


@pytest.mark.parametrize("turned", [False, True])
def test_periodic_sides_must_move_alike(turned: bool) -> None:
    mesh = block(rotation() if turned else None, {"x0": "periodic_a", "x1": "periodic_b"})
    [pair] = pairs_of(mesh)
    assert pair.misses(mesh.points).max() < 1e-14
    assert broken(mesh, mesh.points + [0.1, 0.2, 0.3]) == []
    step = np.zeros_like(mesh.points)
    step[mesh.marker_nodes("periodic_b")[3]] = [0, 0.25, 0]
    [sentence] = broken(mesh, mesh.points + step)
    assert sentence == (
        "periodic_a and periodic_b no longer match: 1 of 16 nodes has its partner elsewhere, "
        "by up to 0.25"
    )


@pytest.mark.parametrize("angle", [30.0, -72.0])
def test_periodic_sides_of_a_sector_turn_about_its_axis(angle: float) -> None:
    flat = block(names={"y0": "cyclic_low", "y1": "cyclic_high"})
    r, t, x = 1 + flat.points[:, 0], np.radians(angle) * flat.points[:, 1], flat.points[:, 2]
    mesh = flat.with_points(np.stack([r * np.cos(t), r * np.sin(t), x], axis=1))
    [pair] = pairs_of(mesh)
    assert pair.turn[1, 0] == pytest.approx(np.sin(np.radians(angle)))
    radial = mesh.points * [1, 1, 0] * 0.1  # commutes with the turn
    assert broken(mesh, mesh.points + radial) == []
    assert len(broken(mesh, mesh.points + [0.1, 0, 0])) == 1


def test_wedge_sides_are_planes_and_partners() -> None:
    flat = block(kinds={"y0": "wedge", "y1": "wedge"})
    r, t, x = 1 + flat.points[:, 0], np.radians(5 * flat.points[:, 1] - 2.5), flat.points[:, 2]
    mesh = flat.with_points(np.stack([x, r * np.cos(t), r * np.sin(t)], axis=1))
    assert len(planes_of(mesh)) == 2
    assert len(pairs_of(mesh)) == 1
    assert broken(mesh, mesh.points * [1.5, 1, 1]) == []
    assert len(broken(mesh, mesh.points + [0, 0, 0.1])) == 3


def test_front_and_back_stay_opposite() -> None:
    mesh = block(kinds={"z0": "empty", "z1": "empty"})
    assert broken(mesh, mesh.points * [1.2, 0.9, 1]) == []
    shear = mesh.points + mesh.points[:, 2:] * [0.125, 0, 0]
    [sentence] = broken(mesh, shear)
    assert sentence == (
        "front and back of z0 and z1 are no longer opposite: 16 of 16 nodes have their partners "
        "elsewhere, by up to 0.125"
    )


def test_sent_and_received_nodes_of_su2_are_partners(tmp_path: Path) -> None:
    path = tmp_path / "halo.su2"
    path.write_text(
        "NDIME= 2\nNELEM= 2\n9 0 1 3 2 0\n9 1 4 5 3 1\nNPOIN= 6\n0 0\n1 0\n0 1\n1 1\n2 0\n2 1\n"
        "NMARK= 2\nMARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 2\nSEND_RECV= 1\n1 0 0\n1 2 0\n"
        "MARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 2\nSEND_RECV= -1\n1 4 1\n1 5 1\n"
    )
    mesh = read_mesh(path)
    [pair] = pairs_of(mesh)
    assert (pair.first.tolist(), pair.second.tolist()) == ([0, 2], [4, 5])
    assert broken(mesh, mesh.points + [1, 1, 0]) == []
    assert broken(mesh, mesh.points * [1, 2, 1]) == []
    assert len(broken(mesh, mesh.points * [2, 1, 1])) == 1  # the pitch has changed
    assert len(broken(mesh, mesh.points + mesh.points[:, :1] * [0, 0.1, 0])) == 1


def test_openfoam_tells_the_partners(tmp_path: Path, shared: Path) -> None:
    case = tmp_path / "case"
    shutil.copytree(shared / "meshes" / "openfoam" / "airFoil2D", case)
    boundary = case / "constant" / "polyMesh" / "boundary"
    text = boundary.read_text()
    text = re.sub(r"type\s+patch;", "type cyclic; neighbourPatch outlet;", text, count=1)
    boundary.write_text(text)
    assert read_mesh(case).partners == {"inlet": "outlet"}
