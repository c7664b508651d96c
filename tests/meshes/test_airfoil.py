"""Airfoils: the NACA formula, both file layouts, and their pitfalls."""

from __future__ import annotations

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.meshes.airfoil import contour, contour_mesh, naca4, read_airfoil

SELIG = "A name 12%\n 1.0 0.01\n0.5 0.1\n 0.0 0.0\n0.5 -0.1\n1.0 -0.01\n"
LEDNICER = "A name\n  3.  3.\n\n0.0 0.0\n0.5 0.1\n1.0 0.01\n\n0.0 0.0\n0.5 -0.1\n1.0 -0.01\n"


def test_both_layouts_give_the_same_contour(tmp_path):
    (tmp_path / "s.dat").write_text(SELIG)
    (tmp_path / "l.dat").write_text(LEDNICER)
    expected = [[1, 0.01], [0.5, 0.1], [0, 0], [0.5, -0.1], [1, -0.01]]
    assert read_airfoil(tmp_path / "s.dat").tolist() == expected
    assert read_airfoil(tmp_path / "l.dat").tolist() == expected


def test_moving_a_point_changes_its_numbers_only(tmp_path):
    for text in (SELIG, LEDNICER):
        (tmp_path / "a.dat").write_text(text)
        mesh = read_mesh(tmp_path / "a.dat")
        points = mesh.points.copy()
        points[1, 1] = 1 / 3
        write_mesh(mesh, tmp_path / "b.dat", points)
        new = (tmp_path / "b.dat").read_text()
        assert new == text.replace("0.5 0.1", "0.5 0.3333333333333333")


def test_every_real_airfoil_is_read_as_one_contour(shared, tmp_path):
    for path in sorted((shared / "airfoils").glob("*.dat")):
        theirs = np.loadtxt(path, skiprows=1)
        ours = read_airfoil(path)
        assert np.array_equal(ours, theirs), path.name
        mesh = read_mesh(path)
        assert mesh.dimension == 2
        assert mesh.template.patched(mesh.points) == path.read_bytes()


def test_repeated_neighbours_are_dropped_from_the_contour_but_not_from_the_file(tmp_path):
    (tmp_path / "a.dat").write_text("x\n1 0\n0.5 .1\n0.5 0.10\n0 0\n0.5 -.1\n1 0\n")
    mesh = read_mesh(tmp_path / "a.dat")
    assert len(mesh.points) == 6
    assert contour(mesh).tolist() == [[1, 0], [0.5, 0.1], [0, 0], [0.5, -0.1], [1, 0]]


def test_naca_sections_follow_the_published_ordinates():
    # NACA Report 460: half thickness 6.002 % at 30 % chord; the 2412 has 2 % camber at 40 %
    x = 0.5 * (1 - np.cos(np.linspace(0, np.pi, 2001)))
    open_section = naca4("0012", 2001, closed=False)[2000:]
    assert np.interp(0.3, x, -open_section[:, 1]) == pytest.approx(0.06002, abs=5e-6)
    assert -open_section[-1, 1] == pytest.approx(0.00126, abs=5e-6)
    cambered = naca4("naca2412", 2001)
    middle = 0.5 * (cambered[:2001][::-1] + cambered[2000:])
    assert middle[:, 1].max() == pytest.approx(0.02, abs=1e-8)
    assert middle[np.argmax(middle[:, 1]), 0] == pytest.approx(0.4, abs=1e-3)


def test_a_closed_section_ends_where_it_begins():
    section = naca4("4412")
    assert np.array_equal(section[0], section[-1])
    assert contour(contour_mesh(section)).tolist() == section.tolist()


@pytest.mark.parametrize("digits", ["0000", "12", "nacaxxxx", "2012", "0412"])
def test_what_is_no_section_is_refused(digits):
    with pytest.raises(InputError, match="no NACA four-digit section"):
        naca4(digits)


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("x\n1 0\n0 nan\n1 0\n", "line 3: a coordinate is not a finite number"),
        ("x\n1 0\n0 0 0\n1 0\n", "line 3: an airfoil has two coordinates a line"),
        ("x\n1 0\n0 a\n1 0\n", "line 3: expected a number, found 'a'"),
        ("x\n1 0\n1 0\n", "at least three different points"),
    ],
)
def test_a_damaged_file_is_refused_with_place_and_cause(tmp_path, text, cause):
    (tmp_path / "a.dat").write_text(text)
    with pytest.raises(InputError, match=cause):
        read_mesh(tmp_path / "a.dat")
