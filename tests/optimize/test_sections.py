import numpy as np
import pytest

import ffdstudio as ffd
from ffdstudio.meshes.airfoil import naca4
from ffdstudio.optimize.geometry.sections import target_contour, without_base


def blunt(base):
    """NACA 0012 with a base of 2 %, with points of it at both ends."""
    points = naca4("0012", 81)
    side = np.where(np.arange(len(points)) <= len(points) // 2, 1, -1)
    points[:, 1] += 0.01 * side * points[:, 0]
    return np.vstack([base, points, np.array(base)[::-1] * [1, -1]])


@pytest.mark.parametrize(
    "base", [[[1.0, 0.0]], [[1.0, 0.0], [1.0, 0.005]], [[1.0, 0.0], [1.0, 0.0]], [[1.001, 0.0]]]
)
def test_points_of_a_blunt_base_are_left_out(base):
    plain = target_contour(blunt(np.empty((0, 2))))
    for found in (target_contour(blunt(base)), target_contour(np.asfortranarray(blunt(base)))):
        np.testing.assert_array_equal(found.points, plain.points)


def test_a_target_with_a_base_is_fitted_as_well_as_without(tmp_path):
    rms = []
    for name, base in (("without", np.empty((0, 2))), ("with", [[1.0, 0.0]])):
        rows = "\n".join(f"{x:.9f} {y:.9f}" for x, y in blunt(base))
        (tmp_path / f"{name}.dat").write_text(f"{name}\n{rows}\n")
        target = str(tmp_path / f"{name}.dat")
        rms.append(ffd.fit("naca0012", target, columns=6, adaptive=None).rms)
    assert rms[1] == pytest.approx(rms[0], rel=1e-6)


@pytest.mark.parametrize("name", ["0012", "4412", "0030"])
def test_sections_without_a_base_stay_as_they_are(name):
    for closed in (True, False):
        points = naca4(name, 41, closed=closed)
        np.testing.assert_array_equal(without_base(points), points)


def test_a_slanted_base_is_met_on_both_sides():
    target = blunt(np.empty((0, 2)))
    target[80:] *= [0.9995, 1]  # the lower surface ends ahead of the upper one
    result = ffd.fit("naca0012", target, columns=8)
    ends = result.built.monitor.deformed(result.lattice)[[0, -1], :2]
    np.testing.assert_allclose(ends, target[[0, -1]], atol=1e-5)
    assert result.max_error < 2e-5
