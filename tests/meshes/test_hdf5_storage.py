"""HDF5 files whose data lies elsewhere: no other file is shown as coordinates or overwritten."""

import h5py
import numpy as np
import pytest

from ffdstudio import InputError, read_mesh
from tests.meshes import specimens


def datasets(file):
    found = []
    file.visititems(
        lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None
    )
    return [name for name in found if file[name].dtype.kind == "f" and file[name].size > 2]


def moved_out(path, victim, layout):
    """Put each list of floats of an HDF5 file into another one."""
    with h5py.File(path, "r+") as file:
        names = datasets(file)
        assert names
        for name in names:
            old = file[name]
            shape, kind, attributes = old.shape, old.dtype, dict(old.attrs)
            parent, _, own = name.rpartition("/")
            parent = file[parent] if parent else file
            del parent[own]
            if layout == "external":
                size = int(np.prod(shape)) * kind.itemsize
                parent.create_dataset(own, shape, kind, external=[(str(victim), 0, size)])
            elif layout == "virtual":
                source = h5py.VirtualSource(str(victim), "x", shape)
                virtual = h5py.VirtualLayout(shape, kind)
                virtual[...] = source
                parent.create_virtual_dataset(own, virtual)
            else:
                parent[own] = h5py.ExternalLink(str(victim), "x")
                continue
            for key, value in attributes.items():
                if key not in ("DIMENSION_LIST", "REFERENCE_LIST"):
                    parent[own].attrs[key] = value


@pytest.mark.parametrize("layout", ["external", "virtual", "link"])
@pytest.mark.parametrize("name", ["plain.cgns", "packed.cgns", "hdf5.exo", "packed.exo"])
def test_data_in_another_file_is_refused(tmp_path, name, layout):
    path, victim = tmp_path / name, tmp_path / "victim.bin"
    specimens.SPECIMENS[name](path)
    assert len(read_mesh(path).points)
    if layout == "external":
        victim.write_bytes(bytes(range(256)) * 100)
    else:
        with h5py.File(victim, "w") as file:
            file["x"] = np.arange(1000.0)
    before = victim.read_bytes()
    moved_out(path, victim, layout)
    with pytest.raises(InputError) as error:
        read_mesh(path)
    assert layout == "link" or "lies in another file" in str(error.value)
    assert victim.read_bytes() == before
