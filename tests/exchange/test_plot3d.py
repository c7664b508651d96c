"""PLOT3D boxes of pyGeo."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from ffdstudio import InputError, Lattice, read_lattice, write_lattice
from ffdstudio.exchange import read_lattice_file


def by_words(path):
    """Blocks as lists of control points, by plain loops."""
    words = path.read_text().split()
    count = int(words[0])
    sizes = [tuple(int(w) for w in words[1 + 3 * b : 4 + 3 * b]) for b in range(count)]
    at, blocks = 1 + 3 * count, []
    for ni, nj, nk in sizes:
        net = np.empty((ni, nj, nk, 3))
        for axis in range(3):
            for k in range(nk):
                for j in range(nj):
                    for i in range(ni):
                        net[i, j, k, axis] = float(words[at])
                        at += 1
        blocks.append(net)
    assert at == len(words)
    return blocks


@pytest.mark.parametrize("name", ["dpw4FFD", "oneram6_wingFFD", "rae2822_wingFFD"])
def test_real_boxes_are_read_as_they_stand(shared, name):
    path = shared / "meshes" / "plot3d" / f"{name}.xyz"
    for number, net in enumerate(by_words(path)):
        found = read_lattice_file(path, block=number)
        assert found.exactness.exact
        assert np.array_equal(found.rest.control_points, net)
        assert found.rest.degrees == tuple(min(3, n - 1) for n in net.shape[:3])
        assert found.rest == found.current


def test_the_map_is_the_uniform_clamped_spline_of_scipy(shared):
    rest, _ = read_lattice(shared / "lattices" / "sample_pygeo_write.fmt")
    assert rest.shape == (8, 6, 4)
    u = np.random.default_rng(3).random((50, 3))
    net = rest.control_points
    for k, n in enumerate((8, 6, 4)):  # contract one direction after the other
        inner = np.arange(1, n - 3) / (n - 3)
        t = np.r_[np.zeros(4), inner, np.ones(4)]
        matrix = BSpline.design_matrix(u[:, k], t, 3).toarray()
        net = (
            np.einsum("pi,i...->p...", matrix, net)
            if k == 0
            else np.einsum("pi,pi...->p...", matrix, net)
        )
    assert np.abs(net - rest.evaluate(u)).max() < 1e-14


def test_a_block_comes_back_bit_for_bit(tmp_path):
    rest = Lattice.box([0, 0, 0], [1, 2, 3], shape=(6, 2, 3))
    net = rest.control_points + np.random.default_rng(1).random((6, 2, 3, 3))
    rest = Lattice([3, 1, 2], [u / u[-1] for u in rest.knots], net)
    assert write_lattice(tmp_path / "a.xyz", rest).exact
    assert read_lattice(tmp_path / "a.xyz")[0] == rest
    assert np.array_equal(by_words(tmp_path / "a.xyz")[0], net)


def test_fortran_exponents_are_understood(tmp_path):
    values = "0.0D+00 1.0d+00 " * 12
    (tmp_path / "a.fmt").write_text(f"1\n2 2 2\n{values}")
    assert read_lattice(tmp_path / "a.fmt")[0].control_points[1, 0, 0, 0] == 1.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0\n", "blocks"),
        ("-1\n2 2 2\n", "blocks"),
        ("99999999\n2 2 2\n", "blocks"),
        ("1\n2 2\n", "three sizes"),
        ("1\n2 1 2\n" + "0 " * 12, "at least 2"),
        ("1\n2 2 2\n" + "0 " * 23, "24 coordinates"),
        ("1\n2 2 2\n" + "0 " * 25, "24 coordinates"),
        ("1\n2 2 2\n" + "0 " * 23 + "nan", "finite"),
        ("1\n2 2 2\n" + "0 " * 23 + "x", "'x' is no number"),
        ("1\n2 2 2\n" + "0 " * 23 + "1_0", "no finite number"),
        ("1\n1000000 1000000 1000000\n0", "announced"),
        ("1.5\n2 2 2\n", "whole number"),
        ("\x00\x01", "not a text file"),
    ],
)
def test_bad_files_are_refused_in_one_sentence(tmp_path, text, words):
    (tmp_path / "a.xyz").write_text(text)
    with pytest.raises(InputError, match=words):
        read_lattice(tmp_path / "a.xyz")


def test_a_block_that_is_not_there_is_named(shared):
    with pytest.raises(InputError, match="no block 7; it has: 0"):
        read_lattice(shared / "meshes" / "plot3d" / "oneram6_wingFFD.xyz", block=7)


def test_weights_and_other_degrees_are_refused_with_a_remedy(tmp_path):
    box = Lattice.box([0, 0, 0], [1, 1, 1], shape=(6, 4, 4))
    weighted = box.moved(weights=np.full(box.shape, 2.0))
    with pytest.raises(InputError, match=r"weights are not all 1; write \.lattice\.json"):
        write_lattice(tmp_path / "a.xyz", weighted)
    with pytest.raises(InputError, match="degree 2 in direction i should be 3"):
        write_lattice(tmp_path / "a.xyz", Lattice.box([0, 0, 0], [1, 1, 1], (6, 4, 4), (2, 3, 3)))
    assert not (tmp_path / "a.xyz").exists()
