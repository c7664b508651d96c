"""Bad input to every command: one line, exit code 2, existing files as they were."""

import os
from pathlib import Path

import numpy as np
import pytest

from ffdstudio import Lattice, Project, write_lattice

TRUNCATED, EMPTY, NOISE, BLANK = "truncated", "empty", "noise", "blank"
NOISE_BYTES = np.random.default_rng(99).integers(0, 256, 5000, dtype=np.uint8).tobytes()


def damaged(path: Path, how: str) -> Path:
    whole = path.read_bytes()
    data = {TRUNCATED: whole[: len(whole) * 2 // 3], EMPTY: b"", NOISE: NOISE_BYTES, BLANK: b" \n"}
    path.write_bytes(data[how])
    return path


@pytest.fixture
def lattice(tmp_path):
    path = tmp_path / "box.lattice.json"
    write_lattice(path, Lattice.box([0, 0], [1, 1], shape=(4, 4)))
    return path


@pytest.fixture
def plot3d(tmp_path):
    path = tmp_path / "box.xyz"
    write_lattice(path, Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 4, 4)))
    return path


@pytest.fixture
def project(tmp_path, square):
    project = Project()
    project.add_mesh(square)
    project.save(tmp_path / "p.ffdproj")
    return tmp_path / "p.ffdproj"


def commands(bad, good_mesh, good_lattice, out):
    """Calls that read the bad file; each may write to `out`."""
    if bad.suffix == ".ffdproj":
        return [["info", bad]]
    if bad.suffix == ".su2":
        return [
            ["info", bad],
            ["lattice", bad, "-o", out],
            ["morph", bad, good_lattice, "-o", out],
            ["convert", bad, out],
            ["convert", good_lattice, bad],
        ]
    return [
        ["info", bad],
        ["convert", bad, out],
        ["morph", good_mesh, bad, "-o", out],
    ]


def refused(ffdstudio, words, keep):
    """The call fails properly and leaves `keep` (path -> bytes) alone."""
    assert ffdstudio(*words) == 2, words
    assert ffdstudio.out == ""
    assert ffdstudio.err.startswith("ffdstudio: error: ")
    assert ffdstudio.err.count("\n") == 1
    assert "a fault of ffdstudio itself" not in ffdstudio.err, ffdstudio.err
    for path, data in keep.items():
        assert path.read_bytes() == data


def folder_bytes(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("how", [TRUNCATED, EMPTY, NOISE, BLANK])
@pytest.mark.parametrize("kind", ["square", "lattice", "plot3d", "project"])
def test_damaged_files(ffdstudio, request, square, tmp_path, kind, how):
    bad = request.getfixturevalue(kind)
    good_mesh, good_lattice = tmp_path / "good.su2", tmp_path / "good.lattice.json"
    good_mesh.write_bytes(square.read_bytes())
    write_lattice(good_lattice, Lattice.box([0, 0], [1, 1], shape=(4, 4)))
    damaged(bad, how)
    for suffix in (".su2", ".lattice.json"):
        out = tmp_path / f"precious{suffix}"
        out.write_bytes(b"precious")
        for words in commands(bad, good_mesh, good_lattice, out):
            refused(ffdstudio, words, folder_bytes(tmp_path))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("0.125 0.0", "nan 0.0"),
        ("0.125 0.0", "inf 0.0"),
        ("0.125 0.0", "1e999 0.0"),
        ("0.125 0.0", "0.125 abc"),
        ("0.125 0.0", "0.125"),
        ("5 0 1 10", "5 0 1 81"),
        ("5 0 1 10", "5 0 1 -1"),
        ("5 0 1 10", "5 0 1"),
        ("5 0 1 10", "77 0 1 10"),
        ("5 0 1 10", "5 0 1 1.5"),
        ("NELEM= 128", "NELEM= 127"),
        ("NELEM= 128", "NELEM= 129"),
        ("NPOIN= 81", "NPOIN= 80"),
        ("NPOIN= 81", "NPOIN= 99999999999999999999"),
        ("NPOIN= 81", "NPOIN= -1"),
        ("NPOIN= 81", "NPOIN= x"),
        ("NDIME= 2", "NDIME= 4"),
        ("MARKER_ELEMS= 8", "MARKER_ELEMS= 9"),
        ("3 0 1\n", "3 0 9999\n"),
    ],
)
def test_damaged_numbers_in_a_mesh(ffdstudio, square, lattice, tmp_path, old, new):
    text = square.read_text()
    assert old in text
    square.write_text(text.replace(old, new, 1))
    out = tmp_path / "out.su2"
    out.write_bytes(b"precious")
    for words in (["info", square], ["morph", square, lattice, "-o", out]):
        refused(ffdstudio, words, folder_bytes(tmp_path))


def test_missing_files_and_folders(ffdstudio, square, lattice, tmp_path):
    gone = tmp_path / "gone"
    for words in (
        ["info", gone],
        ["info", tmp_path / "gone.lattice.json"],
        ["info", tmp_path / "gone.ffdproj"],
        ["info", tmp_path],
        ["lattice", gone, "-o", tmp_path / "x.lattice.json"],
        ["morph", gone, lattice, "-o", tmp_path / "x.su2"],
        ["morph", square, gone, "-o", tmp_path / "x.su2"],
        ["morph", square, tmp_path, "-o", tmp_path / "x.su2"],
        ["convert", gone, tmp_path / "x.lattice.json"],
        ["convert", lattice, tmp_path / "gone.su2"],
    ):
        refused(ffdstudio, words, folder_bytes(tmp_path))
        assert not list(tmp_path.glob("x.*"))


def writers(square, lattice, target):
    return [
        ["lattice", square, "-o", f"{target}.lattice.json"],
        ["morph", square, lattice, "-o", f"{target}.su2"],
        ["convert", lattice, f"{target}.lattice.json"],
    ]


def test_paths_that_cannot_be_written(ffdstudio, square, lattice, tmp_path):
    (tmp_path / "folder.su2").mkdir()
    (tmp_path / "folder.lattice.json").mkdir()
    places = [tmp_path / "no" / "such" / "folder", square / "below", "/proc/nowhere/x"]
    places += [tmp_path / ("n" * 300), f"{tmp_path}/nul\0byte"]
    for place in places:
        for words in writers(square, lattice, place):
            refused(ffdstudio, words, folder_bytes(tmp_path))
    refused(ffdstudio, ["lattice", square, "-o", tmp_path / "folder.lattice.json"], {})
    refused(ffdstudio, ["convert", lattice, tmp_path / "folder.lattice.json"], {})


def test_a_full_disk_leaves_the_old_files(ffdstudio, square, lattice, tmp_path, monkeypatch):
    target = tmp_path / "precious"
    for suffix in (".su2", ".lattice.json"):
        (tmp_path / f"precious{suffix}").write_bytes(b"precious")

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    for words in writers(square, lattice, target):
        refused(ffdstudio, words, folder_bytes(tmp_path))
        assert "no space left" in ffdstudio.err
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "box.lattice.json",
        "precious.lattice.json",
        "precious.su2",
        "square.su2",
    ]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_device_that_is_full(ffdstudio, square, lattice, tmp_path):
    link = tmp_path / "full.su2"
    link.symlink_to("/dev/full")
    refused(ffdstudio, ["morph", square, lattice, "-o", link, "--boxes", "keep"], {})
