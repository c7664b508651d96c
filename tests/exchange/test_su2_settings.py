"""What an SU2 configuration says besides a box's corners is taken over, or named as lost."""

import numpy as np
import pytest

from ffdstudio import InputError
from ffdstudio.cli.main import main
from ffdstudio.exchange import read_lattice_file, write_lattice
from tests.project.scenes import write_cube

CUBE = "0,0,0, 1,0,0, 1,1,0, 0,1,0, 0,0,1, 1,0,1, 1,1,1, 0,1,1"
OTHER = "1,0,0, 2,0,0, 2,1,0, 1,1,0, 1,0,1, 2,0,1, 2,1,1, 1,1,1"
FLAT = "0,0,0, 1,0,0, 1,1,0, 0,1,0, 0,0,0, 0,0,0, 0,0,0, 0,0,0"


def config(folder, *lines, corners=CUBE, degrees="3, 4, 5"):
    path = folder / "a.cfg"
    head = [f"FFD_DEFINITION= (BOX, {corners})", f"FFD_DEGREE= ({degrees})", "FFD_BLENDING= BEZIER"]
    path.write_text("\n".join([*head, *lines, ""]))
    return path


@pytest.mark.parametrize("system", ["SPHERICAL", "TOROIDAL", "polar", "POLAR"])
def test_corners_in_angles_are_no_points(tmp_path, system):
    path = config(tmp_path, f"FFD_COORD_SYSTEM= {system}", "FFD_AXIS= (0, 0, 0)")
    with pytest.raises(InputError, match=r"a\.cfg: FFD_COORD_SYSTEM.* only CARTESIAN"):
        read_lattice_file(path)


@pytest.mark.parametrize(
    "lines", [[], ["FFD_COORD_SYSTEM= CARTESIAN"], ["% FFD_COORD_SYSTEM= POLAR"]]
)
@pytest.mark.parametrize("more", [[], ["FFD_CONTINUITY= NO_DERIVATIVE"], ["FFD_FIX_I= (0)"]])
def test_what_changes_nothing_is_exact(tmp_path, lines, more):
    found = read_lattice_file(config(tmp_path, *lines, *more))
    assert found.exactness.exact
    assert not found.notes
    assert (found.frozen, found.rest) == (0, found.current)


@pytest.mark.parametrize(
    ("planes", "layers", "faces"),
    [
        ({"I": [0, 3], "J": [0, 4], "K": [0, 5]}, 1, ()),
        ({"I": [0], "J": [0, 4], "K": [0, 5]}, 1, ((0, 1),)),
        ({"K": [0, 1, 4, 5]}, 2, ((0, 0), (0, 1), (1, 0), (1, 1))),
        ({"I": [0, 3]}, 1, ((1, 0), (1, 1), (2, 0), (2, 1))),
    ],
)
def test_held_planes_are_frozen_layers(tmp_path, planes, layers, faces):
    lines = [f"FFD_FIX_{d}= ({', '.join(map(str, held))})" for d, held in planes.items()]
    found = read_lattice_file(config(tmp_path, "FFD_CONTINUITY= USER_INPUT", *lines))
    assert (found.frozen, found.open_faces) == (layers, faces)
    assert found.exactness.exact
    write_lattice(
        tmp_path / "b.cfg", found.rest, frozen=found.frozen, open_faces=found.open_faces, tag="BOX"
    )
    again = read_lattice_file(tmp_path / "b.cfg")
    assert (again.frozen, again.open_faces, again.rest) == (layers, faces, found.rest)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["FFD_CONTINUITY= 1ST_DERIVATIVE"], "FFD_CONTINUITY= 1ST_DERIVATIVE is lost"),
        (["FFD_CONTINUITY= 2ND_DERIVATIVE", "FFD_FIX_I= (0)"], "2ND_DERIVATIVE is lost"),
        (["FFD_CONTINUITY= USER_INPUT", "FFD_FIX_J= (0, 2)"], "inside the box"),
        (["FFD_CONTINUITY= USER_INPUT", "FFD_FIX_J= (0, 1)", "FFD_FIX_K= (0)"], "more planes"),
        (["FFD_CONTINUITY= USER_INPUT", "FFD_FIX_J= (0, 1, 2, 3, 4)"], "every control point"),
        (
            ["DV_KIND= FFD_TWIST", "DV_PARAM= (BOX, 0,0,0, 0,0,1)", "DV_VALUE= 2"],
            "FFD_TWIST is lost",
        ),
        (["DV_KIND= FFD_CONTROL_POINT", "DV_VALUE= 0.1"], "do not belong together"),
        (
            ["DV_KIND= FFD_CONTROL_POINT", "DV_PARAM= (BOX, 0,0,0, 0,0,1)", "DV_VALUE= 1, 2"],
            "do not",
        ),
    ],
)
def test_what_is_lost_is_named_and_not_called_exact(tmp_path, capsys, lines, words):
    path = config(tmp_path, *lines)
    found = read_lattice_file(path)
    assert not found.exactness.exact
    assert words in str(found.exactness)
    assert any(words in note for note in found.notes)
    write_cube(tmp_path / "cube.su2")
    main(["morph", str(tmp_path / "cube.su2"), str(path), "-o", str(tmp_path / "out.su2")])
    assert words in capsys.readouterr().err


WRONG = [
    ["FFD_CONTINUITY= SOMETIMES"],
    ["FFD_CONTINUITY= USER_INPUT", "FFD_FIX_I= (9)"],
    ["FFD_CONTINUITY= USER_INPUT", "FFD_FIX_I= (x)"],
    ["DV_KIND= FFD_CONTROL_POINT", "DV_PARAM= (BOX, 9,0,0, 0,0,1)", "DV_VALUE= 1"],
    ["DV_KIND= FFD_CONTROL_POINT", "DV_PARAM= (BOX, 0,0,0, 0,1)", "DV_VALUE= 1"],
    ["DV_KIND= FFD_CONTROL_POINT", "DV_PARAM= (BOX, 0,0,0, 0,0,a)", "DV_VALUE= 1"],
    ["DV_KIND= FFD_CONTROL_POINT", "DV_PARAM= (BOX, 0,0,0, 0,0,1)", "DV_VALUE= one"],
]


@pytest.mark.parametrize("lines", WRONG)
def test_what_cannot_be_understood_is_one_sentence(tmp_path, lines):
    with pytest.raises(InputError, match=r"a\.cfg: "):
        read_lattice_file(config(tmp_path, *lines))


def moved(tmp_path, *lines, **options):
    found = read_lattice_file(config(tmp_path, *lines, **options))
    assert found.exactness.exact, found.exactness
    return found.current.control_points - found.rest.control_points


def test_values_of_control_points_move_them(tmp_path):
    step = moved(
        tmp_path, "DV_KIND= FFD_CONTROL_POINT, FFD_CONTROL_POINT",
        "DV_PARAM= (BOX, 1, 2, 3, 0.0, 0.0, 1.0); (BOX, 0, 0, 0, 1.0, 0.5, 0.0)",
        "DV_VALUE= 0.1, -2",
    )  # fmt: skip
    expected = np.zeros_like(step)
    expected[1, 2, 3], expected[0, 0, 0] = [0, 0, 0.1], [-2, -1, 0]
    assert np.allclose(step, expected, atol=1e-15)


def test_minus_one_means_all_and_held_planes_stay(tmp_path):
    step = moved(
        tmp_path, "FFD_CONTINUITY= USER_INPUT", "FFD_FIX_K= (0, 5)", "DV_KIND= FFD_CONTROL_POINT",
        "DV_PARAM= (BOX, 1, 2, -1, 0, 1, 0)", "DV_VALUE= 0.5",
    )  # fmt: skip
    expected = np.zeros_like(step)
    expected[1, 2, 1:5, 1] = 0.5
    assert np.allclose(step, expected, atol=1e-15)


def test_variables_of_a_box_in_the_plane(tmp_path):
    step = moved(
        tmp_path, "DV_KIND= FFD_CONTROL_POINT_2D", "DV_PARAM= (BOX, 1, 2, 0.0, 1.0)", "DV_VALUE= 3",
        corners=FLAT, degrees="3, 4, 0",
    )  # fmt: skip
    assert step[1, 2].tolist() == [0, 3, 0]
    assert np.count_nonzero(step) == 1


def test_variables_of_another_box_are_not_ours(tmp_path):
    path = config(tmp_path, "DV_KIND= FFD_TWIST", "DV_PARAM= (OTHER, 0,0,0)", "DV_VALUE= 1")
    assert read_lattice_file(path).exactness.exact
