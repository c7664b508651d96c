"""VTK XML files: sizes held against what is announced, kinds told apart, ranges of no account."""

from __future__ import annotations

import base64
import zlib

import numpy as np
import pytest
import pyvista as pv

from ffdstudio import InputError, read_mesh, write_mesh
from tests.meshes.oracles import with_vtk
from tests.meshes.specimens import SPECIMENS, vtk_grid


def compressed(plain: bytes) -> bytes:
    packed = zlib.compress(plain)
    header = np.array([1, len(plain), 0, len(packed)], "<u4").tobytes()
    return base64.b64encode(header) + base64.b64encode(packed)


def test_an_array_that_unpacks_to_more_than_announced_is_not_unpacked(tmp_path, monkeypatch):
    text = (
        b'<VTKFile type="UnstructuredGrid" byte_order="LittleEndian" '
        b'compressor="vtkZLibDataCompressor"><UnstructuredGrid><Piece NumberOfPoints="1" '
        b'NumberOfCells="0"><Points><DataArray type="Float64" Name="P" NumberOfComponents="3" '
        b'format="binary">%b</DataArray></Points></Piece></UnstructuredGrid></VTKFile>'
    )
    (tmp_path / "bomb.vtu").write_bytes(text % compressed(bytes(24_000_000)))

    def unpack(*_):
        raise AssertionError("it was unpacked")

    monkeypatch.setattr(zlib, "decompressobj", unpack)
    with pytest.raises(InputError, match="array P: 3 numbers are announced, it has 3000000"):
        read_mesh(tmp_path / "bomb.vtu")


@pytest.mark.parametrize("name", ["ascii.vtu", "inline.vtu", "appended_packed.vtu", "raw.vtu"])
@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        (b'NumberOfPoints="36"', b'NumberOfPoints="9"', "27 numbers are announced, it has 108"),
        (b'NumberOfCells="12"', b'NumberOfCells="9"', "9 numbers are announced, it has 12"),
        (b'NumberOfPoints="36"', b"", "NumberOfPoints must be a whole number"),
    ],
)
def test_counts_that_do_not_fit_the_arrays_are_refused(tmp_path, name, old, new, cause):
    path = tmp_path / name
    SPECIMENS[name](path)
    path.write_bytes(path.read_bytes().replace(old, new))
    with pytest.raises(InputError, match=cause):
        read_mesh(path)


@pytest.fixture(params=[".vtp", ".vts"])
def other(request, tmp_path):
    """Polygons and a structured grid, written by VTK."""
    skin = vtk_grid().extract_surface(algorithm="dataset_surface")
    block = pv.ImageData(dimensions=(3, 4, 2)).cast_to_structured_grid()
    path = tmp_path / f"a{request.param}"
    (skin if request.param == ".vtp" else block).save(path)
    return path


def test_other_kinds_of_data_are_read_and_patched(other, tmp_path):
    mesh = read_mesh(other)
    points = (mesh.points + 1 / 3).astype(np.float32).astype(np.float64)
    target = tmp_path / f"b{other.suffix}"
    write_mesh(mesh, target, points)
    assert np.array_equal(with_vtk(target), points)


def test_a_file_of_one_kind_is_not_written_under_the_name_of_another(other, tmp_path):
    SPECIMENS["raw.vtu"](tmp_path / "a.vtu")
    with pytest.raises(InputError, match=f"not '{other.suffix}'"):
        write_mesh(read_mesh(tmp_path / "a.vtu"), tmp_path / f"b{other.suffix}")


def test_vtk_takes_no_range_from_the_attributes(tmp_path):
    SPECIMENS["ascii.vtu"](tmp_path / "a.vtu")
    mesh = read_mesh(tmp_path / "a.vtu")
    assert b"RangeMax" in (tmp_path / "a.vtu").read_bytes()
    write_mesh(mesh, tmp_path / "b.vtu", mesh.points + 100)
    found = pv.read(tmp_path / "b.vtu")
    lengths = np.linalg.norm(mesh.points + 100, axis=1)
    assert found.GetPoints().GetData().GetRange(-1) == pytest.approx((lengths.min(), lengths.max()))
    assert found.bounds.x_min >= 100
