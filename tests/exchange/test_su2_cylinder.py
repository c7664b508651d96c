"""SU2 configurations whose FFD boxes are spanned in cylindrical coordinates."""

from itertools import permutations

import numpy as np
import pytest

from ffdstudio import InputError, embed
from ffdstudio.exchange import read_lattice_file
from ffdstudio.exchange.su2cylinder import CORNERS

RADII, ANGLES, HEIGHTS = (0.5, 1.25), (-1.2, 0.9), (2.0, 3.5)


def corners(order=(2, 1, 0), axis=(0.0, 0.0, 0.0)):
    """Corners in x, y, z of a sector whose directions are x, angle, radius in some order."""
    ranges = [(RADII, ANGLES, HEIGHTS)[k] for k in order]
    out = []
    for place in CORNERS:
        at = {c: ranges[k][side] for k, (c, side) in enumerate(zip(order, place, strict=True))}
        out.append([at[2], at[0] * np.cos(at[1]), at[0] * np.sin(at[1])])
    return np.array(out) + axis


def write(path, points, *lines, degree=(2, 3, 1)):
    numbers = ", ".join(map(repr, points.ravel().tolist()))
    head = [f"FFD_DEFINITION= (ROTOR, {numbers})", f"FFD_DEGREE= {degree}"]
    path.write_text("\n".join([*head, *lines, ""]))
    return path


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_a_sector_is_read_with_its_directions_as_they_are(tmp_path, order):
    axis = np.array([0.0, 0.3, -0.2])
    lines = ["FFD_COORD_SYSTEM= CYLINDRICAL", "FFD_AXIS= (0.0, 0.3, -0.2)"]
    found = read_lattice_file(write(tmp_path / "a.cfg", corners(order, axis), *lines))
    rest = found.rest
    assert rest.shape == (3, 4, 2)
    assert not found.exactness.exact
    ranges = np.array([(RADII, ANGLES, HEIGHTS)[k] for k in order])
    assert np.abs(rest.domain - ranges).max() < 1e-12
    u = np.random.default_rng(0).uniform(*ranges.T, (500, 3))
    by = {k: u[:, order.index(k)] for k in range(3)}
    x = np.stack([by[2], by[0] * np.cos(by[1]), by[0] * np.sin(by[1])], axis=1) + axis
    bound = embed(rest, x)
    assert bound.inside.all()
    assert np.abs(bound.parameters - u).max() < 1e-12
    middle = x - axis
    middle[:, 1:] *= 0.3  # within the inner radius
    assert not embed(rest, middle + axis).inside.any()


def test_without_a_word_the_same_corners_span_a_straight_box(tmp_path):
    found = read_lattice_file(write(tmp_path / "a.cfg", corners(), degree=(1, 1, 1)))
    assert found.rest.frame is None
    assert found.exactness.exact


@pytest.mark.parametrize(
    ("lines", "points", "words"),
    [
        (["FFD_COORD_SYSTEM= SPHERICAL"], corners(), "SPHERICAL' is not read"),
        (["FFD_COORD_SYSTEM= POLAR"], corners(), "POLAR' is not read"),
        (["FFD_COORD_SYSTEM= CYLINDRICAL"], corners() + [0, 0.1, 0], "span no box there"),
        (["FFD_COORD_SYSTEM= CYLINDRICAL"], corners()[::-1], "must grow along"),
        (["FFD_COORD_SYSTEM= CYLINDRICAL", "FFD_AXIS= (0.0)"], corners(), "three numbers"),
        (
            ["FFD_COORD_SYSTEM= CYLINDRICAL", "FFD_BLENDING= BSPLINE_UNIFORM",
             "FFD_BSPLINE_ORDER= 3, 3, 2"],
            corners(), "BEZIER or order 2",
        ),
        (["FFD_COORD_SYSTEM= CYLINDRICAL"], 0 * corners(), "span no box|the same|grow"),
    ],
)  # fmt: skip
def test_what_is_no_cylinder_is_refused_by_file_and_reason(tmp_path, lines, points, words):
    path = write(tmp_path / "a.cfg", points, *lines)
    with pytest.raises(InputError, match=words) as caught:
        read_lattice_file(path)
    assert str(caught.value).startswith(str(path))


def test_a_design_variable_moves_in_radius_angle_and_x(tmp_path):
    lines = [
        "FFD_COORD_SYSTEM= CYLINDRICAL", "DV_KIND= FFD_CONTROL_POINT, FFD_CONTROL_POINT",
        "DV_PARAM= ( ROTOR, -1, -1, 1, 1.0, 0.0, 0.0 ); ( ROTOR, 1, 2, 0, 0.0, 1.0, 0.0 )",
        "DV_VALUE= 0.1, 0.02",
    ]  # fmt: skip
    found = read_lattice_file(write(tmp_path / "a.cfg", corners(), *lines))
    step = found.current.control_points - found.rest.control_points
    angles = found.rest.greville(1)
    outward = np.stack([0 * angles, np.cos(angles), np.sin(angles)], axis=1)
    assert np.abs(step[:, :, 1] - 0.1 * outward).max() < 1e-15
    radius, angle = found.rest.greville(2)[0], angles[2]
    turned = radius * np.array([0, *(
        f(angle + 0.02) - f(angle) for f in (np.cos, np.sin)
    )])  # fmt: skip
    assert np.abs(step[1, 2, 0] - turned).max() < 1e-15
    assert np.count_nonzero(step[:, :, 0].any(axis=-1)) == 1
    assert "blends motions in radius" in str(found.exactness)
