"""Compressed files of any format: read as their content, written compressed."""

from __future__ import annotations

import gzip
import warnings

import numpy as np
import pytest

from ffdstudio import InputError, read_mesh, write_mesh
from ffdstudio.files import together
from ffdstudio.meshes import MeshWarning
from tests.meshes.specimens import SPECIMENS

NAMES = ("ascii.stl", "binary.stl", "block.obj", "v41_binary.msh", "sector_fluent.msh")
NAMES += ("sector_double.cas", "sector.cas.h5", "a.lb8.ugrid", "raw.vtu", "zones_with_boxes.su2")
pytestmark = pytest.mark.filterwarnings("ignore::ffdstudio.meshes.MeshWarning")


def packed(folder, name):
    SPECIMENS[name](folder / name)
    target = folder / f"{name}.gz"
    target.write_bytes(gzip.compress((folder / name).read_bytes(), mtime=7))
    return target


@pytest.mark.parametrize("name", NAMES)
def test_a_compressed_file_is_the_mesh_that_it_holds(tmp_path, name):
    path = packed(tmp_path, name)
    mesh, plain = read_mesh(path), read_mesh(tmp_path / name)
    assert mesh.format == plain.format
    assert mesh.path == path
    assert np.array_equal(mesh.points, plain.points)
    assert mesh.counts == plain.counts
    assert mesh.marker_counts == plain.marker_counts


@pytest.mark.parametrize("name", NAMES)
def test_at_rest_it_keeps_its_bytes_and_moved_the_content_is_the_plain_file_moved(tmp_path, name):
    path = packed(tmp_path, name)
    mesh, plain = read_mesh(path), read_mesh(tmp_path / name)
    write_mesh(mesh, tmp_path / f"same_{name}.gz", mesh.points.copy())
    assert (tmp_path / f"same_{name}.gz").read_bytes() == path.read_bytes()
    points = mesh.points.copy()
    points[3, : mesh.dimension] += 0.25
    write_mesh(mesh, tmp_path / f"new_{name}.gz", points)
    write_mesh(plain, tmp_path / f"new_{name}", points)
    content = gzip.decompress((tmp_path / f"new_{name}.gz").read_bytes())
    assert content == (tmp_path / f"new_{name}").read_bytes()
    assert np.array_equal(read_mesh(tmp_path / f"new_{name}.gz").points, points) or "stl" in name


def test_a_plain_mesh_can_be_written_compressed_and_a_compressed_one_plain(tmp_path):
    path = packed(tmp_path, "block.obj")
    plain = (tmp_path / "block.obj").read_bytes()
    write_mesh(read_mesh(path), tmp_path / "a.obj")
    assert (tmp_path / "a.obj").read_bytes() == plain
    write_mesh(read_mesh(tmp_path / "block.obj"), tmp_path / "b.obj.gz")
    assert gzip.decompress((tmp_path / "b.obj.gz").read_bytes()) == plain
    write_mesh(read_mesh(path), tmp_path / "c.stl.gz")
    assert read_mesh(tmp_path / "c.stl.gz").counts.keys() == {"triangle"}


def test_it_waits_with_what_belongs_together(tmp_path):
    mesh = read_mesh(packed(tmp_path, "block.obj"))
    with together():
        write_mesh(mesh, tmp_path / "a.obj.gz")
        assert not (tmp_path / "a.obj.gz").exists()
    assert read_mesh(tmp_path / "a.obj.gz").counts == mesh.counts


def test_losses_and_rounding_are_told(tmp_path):
    mesh = read_mesh(packed(tmp_path, "binary.stl"))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        write_mesh(mesh, tmp_path / "a.stl.gz", mesh.points + 0.1)
    assert any("single precision" in str(w.message) for w in said)
    assert all(issubclass(w.category, MeshWarning) for w in said)


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        (lambda raw: raw[:-9], "ends too early"),
        (lambda raw: b"solid" + raw, "damaged compression"),
        (lambda raw: gzip.compress(bytes(400_000_000 // 40), 9), "impossible size"),
        (lambda raw: gzip.compress(b"v 0 0\n"), "line 1"),
    ],
)
def test_damage_is_refused_under_the_name_of_the_file(tmp_path, change, cause):
    path = packed(tmp_path, "block.obj")
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(InputError, match=f"block.obj.gz.*{cause}"):
        read_mesh(path)
