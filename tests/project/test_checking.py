"""Quality after each edit: reports, digests, the cell of each displayed polygon, scales."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from ffdstudio.meshes import Mesh, quality, read_mesh
from ffdstudio.project.checks.checking import BINS, Checks, against, digest, presets
from ffdstudio.project.document import Document
from ffdstudio.project.view.cellmap import NO_CELL, cells_of
from ffdstudio.project.view.scales import Scale
from ffdstudio.project.view.surface import surface_of
from tests.project.scenes import BOX, opened, write_cube, write_square


@pytest.fixture
def cube(tmp_path: Path) -> Document:
    return opened(write_cube(tmp_path / "cube.su2"), BOX)


def move(document: Document, vector: tuple[float, float, float]) -> None:
    edit = document.edit([(2, 2, 2)])
    edit.translate(vector)
    edit.commit()


def test_outer_faces_belong_to_the_cells_that_have_their_nodes(tmp_path: Path) -> None:
    mesh = read_mesh(write_cube(tmp_path / "cube.su2"))
    surface = surface_of(mesh)
    cells = cells_of(mesh, surface)
    hexahedra = mesh.cells["hexahedron"]
    for polygon, cell in enumerate(cells):
        begin, end = surface.offsets[polygon : polygon + 2]
        corners = surface.nodes[surface.connectivity[begin:end]]
        assert set(corners) <= set(hexahedra[cell])


def test_cells_of_a_plane_mesh_are_its_polygons(tmp_path: Path) -> None:
    mesh = read_mesh(write_square(tmp_path / "s.su2"))
    assert cells_of(mesh, surface_of(mesh)).tolist() == list(range(16))


def test_mixed_cells_keep_their_numbers() -> None:
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1], [0.5, 0.5, -1], [2, 0, 0]]
    cells = {"tetra": [[1, 2, 4, 6]], "pyramid": [[0, 1, 2, 3, 4]]}
    mesh = Mesh(points, cells)
    surface = surface_of(mesh)
    found = cells_of(mesh, surface)
    sizes = np.diff(surface.offsets)
    assert set(found[sizes == 4]) == {1}
    assert sorted(np.bincount(found).tolist()) == [3, 4]
    assert NO_CELL not in found


def test_nothing_is_measured_while_nobody_looks(cube: Document) -> None:
    checks = Checks(cube)
    move(cube, (0.1, 0, 0))
    assert checks.report("body1") is None


def test_a_report_follows_each_edit_and_undo(cube: Document) -> None:
    checks, told = Checks(cube), []
    checks.changed.connect(told.append)
    checks.watch(True)
    first = checks.report("body1")
    assert first is not None
    assert first.measures["volume_ratio"] == pytest.approx(1)
    move(cube, (0.3, 0.1, 0))
    report = checks.report("body1")
    assert report is not None
    assert checks.current("body1")
    body = cube.model.bodies[0]
    volume = cube.volume(body.key)
    assert volume is not None
    expected = quality(Mesh(body.mesh.points, body.mesh.cells), volume.points)
    np.testing.assert_allclose(
        report.measures["non_orthogonality"], expected.measures["non_orthogonality"], atol=1e-12
    )
    cube.undo()
    again = checks.report("body1")
    assert again is not None
    assert again.measures["volume_ratio"] == pytest.approx(1)
    assert len(told) >= 3


def test_a_body_that_goes_takes_its_report_along(cube: Document) -> None:
    checks = Checks(cube)
    checks.watch(True)
    cube.clear()
    assert checks.report("body1") is None


def test_bodies_that_go_together_are_all_gone_when_the_first_is_told(
    cube: Document, tmp_path: Path
) -> None:
    checks, told = Checks(cube), []
    cube.open_mesh(write_square(tmp_path / "square.su2"))
    checks.watch(True)
    keys = [body.key for body in cube.model.bodies]
    assert all(checks.current(key) for key in keys)

    def look(key: str) -> None:
        told.append((key, [checks.current(k) or checks.report(k) is not None for k in keys]))

    checks.changed.connect(look)
    cube.clear()
    assert told == [(key, [False, False]) for key in keys]


def test_nothing_is_known_of_a_body_that_is_not_there(cube: Document) -> None:
    checks = Checks(cube)
    checks.watch(True)
    assert not checks.current("body7")
    assert checks.report("body7") is None
    seen: list[bool] = []
    cube.structure_changed.disconnect(checks._on_structure)  # who hears it before the checks do
    cube.structure_changed.connect(lambda: seen.append(checks.report("body1") is None))
    cube.clear()
    assert seen == [True]
    assert not checks.current("body1")


def test_another_project_with_the_same_keys_is_measured_anew(
    cube: Document, tmp_path: Path
) -> None:
    checks = Checks(cube)
    checks.watch(True)
    cube.save(tmp_path / "a.ffdproj")
    first = checks.report("body1")
    cube.open(tmp_path / "a.ffdproj")
    second = checks.report("body1")
    assert second is not None
    assert second is not first


def test_a_digest_counts_every_cell_before_and_now(cube: Document) -> None:
    checks = Checks(cube)
    checks.watch(True)
    move(cube, (0.4, 0.2, 0.1))
    made = checks.digest("body1", "skewness")
    assert made is not None
    assert (made.now.sum(), made.before.sum()) == (27, 27)
    assert made.edges[0] <= 0 <= made.worst[0].value <= made.edges[-1]
    assert made.worst[0].value == made.statistics.max
    report = checks.report("body1")
    assert report is not None
    cell = made.worst[0].cell
    assert (
        made.change[cell] == report.measures["skewness"][cell] - report.undeformed["skewness"][cell]
    )


def test_ratios_change_against_one(cube: Document) -> None:
    checks = Checks(cube)
    checks.watch(True)
    move(cube, (0.4, 0, 0))
    report = checks.report("body1")
    assert report is not None
    made = digest(report, "volume_ratio")
    np.testing.assert_allclose(made.change, report.measures["volume_ratio"] - 1)
    assert made.before.sum() == 0


def test_limits_of_a_preset_count_cells_beyond(cube: Document) -> None:
    checks = Checks(cube)
    checks.watch(True)
    move(cube, (-15.0, 0, 0))
    report = checks.report("body1")
    assert report is not None
    rows = {limit.measure: (before, now) for limit, before, now in against(report, "OpenFOAM")}
    assert rows["non_orthogonality"][0] == 0
    assert rows["non_orthogonality"][1] == (report.measures["non_orthogonality"] > 70).sum() > 0
    assert presets() == ["Fluent", "OpenFOAM", "SU2"]


def test_cells_without_a_value_are_left_out_of_scales() -> None:
    scale = Scale.of(np.array([np.nan, 1.0, np.inf, 3.0]))
    assert scale == Scale(1.0, 3.0)
    np.testing.assert_array_equal(scale.place([2.0, np.nan]), [0.5, np.nan])


def test_a_scale_around_a_value_is_symmetric() -> None:
    assert Scale.around(np.array([0.5, 1.25]), 1.0) == Scale(0.5, 1.5)


def test_equal_values_have_a_bin_around_them() -> None:
    edges = Scale.of(np.array([2.0, 2.0])).edges(4)
    assert edges[0] < 2 < edges[-1]
    assert (np.diff(edges) > 0).all()
    zero = Scale.of(np.zeros(3)).edges(4)
    assert zero[0] <= 0 <= zero[-1]
    assert np.isfinite(zero).all()


def test_powers_of_ten_fill_the_scale() -> None:
    scale = Scale(1e-3, 1e3, log=True)
    assert scale.value(0.5) == pytest.approx(1)
    assert scale.edges(6)[[0, 3, 6]].tolist() == pytest.approx([1e-3, 1, 1e3])


def test_one_tiny_value_does_not_stretch_the_scale() -> None:
    assert not Scale.of(np.array([1e-16, 0.1, 0.2, 0.6])).log


def test_measures_up_to_one_are_counted_over_even_steps() -> None:
    values = np.concatenate([np.full(1000, 1e-4), [0.9]])
    assert Scale.of(values).log
    report = SimpleNamespace(
        measures={"skewness": values, "aspect_ratio": values},
        undeformed={"skewness": values, "aspect_ratio": values},
        statistics=lambda name: None,
        worst=lambda name, count: [],
    )
    shown = digest(cast(Any, report), "skewness")
    assert not shown.scale.log
    assert np.allclose(np.diff(shown.edges), (0.9 - 1e-4) / BINS)
    assert shown.now[[0, -1]].tolist() == [1000, 1]
    assert digest(cast(Any, report), "aspect_ratio").scale.log
