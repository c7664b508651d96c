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
        ("x\n1 0\n.5 .1\n0 0\n.5 -0.1\n1.0\n", "line 6: an airfoil has two coordinates a line"),
        ("x\n1 0\n.5 .1\nsee me\n0 0\n.5 -0.1\n1 0\n", "line 4: expected a number, found 'see'"),
        ("x\n36 36\n1 0\n.5 .1\n0 0\n.5 -.1\n1 0\n", "36 and 36 are neither a point"),
        ("x\n1 0\n.5 .1\n0 0\n.5 -0.1\n1.0 -.0x\n", "line 6: expected a number, found '-.0x'"),
        ("only words\nand more\n", "no coordinates"),
    ],
)
def test_a_damaged_file_is_refused_with_place_and_cause(tmp_path, text, cause):
    (tmp_path / "a.dat").write_text(text)
    with pytest.raises(InputError, match=cause):
        read_mesh(tmp_path / "a.dat")


POINTS = [[1.0, 0.01], [0.5, 0.1], [0.1, 0.05], [0.0, 0.0], [0.4, -0.06], [1.0, -0.01]]
LINES = [f"{x} {y}" for x, y in POINTS]


def joined(*lines: str) -> str:
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "text",
    [
        joined("name", *LINES, "", "made by hand, 12 % thick", "cm0 -0.02", "http://x.org 3"),
        joined("name", *LINES, "26/10/2001"),
        joined("name", "of the section", "", *LINES),
        joined("blade", " -2.0 3.0 -2.6 3.4", *LINES),
        joined("blade", " -2.0 3.0 -2.6 3.4 1.0", *LINES),
        joined("name", *(line.replace(" ", ", ") for line in LINES)),
        joined("name", *(line.replace(" ", ";") for line in LINES)),
        joined("name", *(line.replace(".", ",") for line in LINES)),
        joined("name", *(line + " 0.0" for line in LINES)),
        joined("name", *(f"{k + 1} {line}" for k, line in enumerate(LINES))),
        joined("name", *(line.replace("0.1", "1.0D-01") for line in LINES)),
        joined("name", *LINES[:3], "", *LINES[3:]),
        joined("name", *LINES[::-1]),
        joined("no counts", "0 0", *LINES[2::-1], "", "0.0 0.0", *LINES[4:]),
        joined("counts", "4 3", "0 0", *LINES[2::-1], "", "0.0 0.0", *LINES[4:]),
        joined("from the nose", *LINES[3:], *LINES[:4]),
        joined("from the nose, below", *LINES[3::-1], *LINES[:2:-1]),
        joined("old Mac", *LINES).replace("\n", "\r"),
        joined("DOS", *LINES).replace("\n", "\r\n"),
    ],
)
def test_what_people_add_to_these_files_is_read_past(tmp_path, text):
    path = tmp_path / "a.dat"
    path.write_bytes(text.encode())
    assert read_airfoil(path).tolist() == POINTS
    mesh = read_mesh(path)
    if "," not in text or "blade" in text:
        assert mesh.template.patched(mesh.points) == text.encode()
    points = mesh.points + [0, 1 / 3, 0]
    write_mesh(mesh, tmp_path / "b.dat", points)
    np.testing.assert_array_equal(read_mesh(tmp_path / "b.dat").points, points)


FLAP = [[1.3, -0.1], [1.1, 0.02], [0.95, -0.02], [1.1, -0.04], [1.3, -0.1]]


@pytest.mark.parametrize("between", ["999.0 999.0", "", "flap", "  999.  999.\n"])
def test_the_elements_of_a_section_are_told_apart(tmp_path, between):
    path = tmp_path / "slotted.dat"
    path.write_text(joined("slotted", *LINES, between, *(f"{x} {y}" for x, y in FLAP)))
    assert read_airfoil(f"{path}#1").tolist() == POINTS
    assert read_airfoil(f"{path}#2").tolist() == FLAP
    with pytest.raises(InputError, match=r"holds 2 elements.*choose one"):
        read_airfoil(path)
    with pytest.raises(InputError, match="no element 3: it has 2"):
        read_airfoil(f"{path}#3")
    mesh = read_mesh(path)
    assert mesh.template.patched(mesh.points) == path.read_bytes()
    assert list(mesh.markers) == ["element 1", "element 2"]


def test_the_first_element_of_a_plain_file_is_the_file(tmp_path):
    (tmp_path / "a.dat").write_text(SELIG)
    assert read_airfoil(f"{tmp_path}/a.dat#1").tolist() == read_airfoil(tmp_path / "a.dat").tolist()


def test_a_section_around_the_nose_with_one_trailing_edge_point_is_closed(tmp_path):
    sharp = [[1, 0], [0.5, 0.1], [0, 0], [0.5, -0.1], [1, 0]]
    (tmp_path / "a.dat").write_text("x\n0 0\n0.5 -0.1\n1 0\n0.5 0.1\n0 0\n")
    assert read_airfoil(tmp_path / "a.dat").tolist() == sharp
