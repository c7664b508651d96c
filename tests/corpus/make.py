"""Makes the corpus: small files of our own, one for each kind of fault that was found once.

They are kept beside this script because the faults were: each must be refused in one sentence
(or, an evaluation, count as none) for ever, and the campaign goes on from them.
"""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).parent
MESH = b"NDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n0 0\n1 0\n0 1\nNMARK= 0\n"
HEADER = '{"format": "ffdstudio-journal", "schema": 1}\n'
BOX = '{"do": "create box", "name": "B", "lower": [0, 0, 0], "upper": [1, 1, 1], "shape": %s, '
BOX += '"degrees": [1, 1, 1]}\n'
CASE = '[shape]\nsource = "naca0012"\npoints = 61\n[lattice]\nshape = [5, 2]\n'
CORNERS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"


def project(sections: str = "{}", bodies: str = "[]", **entries: bytes) -> bytes:
    text = (
        '{"format": "ffdstudio-project", "schema": 1, "program": "x", "lattices": [], '
        f'"bodies": {bodies}, "sections": {sections}}}'
    )
    return zipped({"manifest.json": text.encode()} | entries)


def zipped(entries: dict[str, bytes], link: bool = False) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in entries.items():
            info = zipfile.ZipInfo("x", date_time=(1980, 1, 1, 0, 0, 0))
            info.filename, info.compress_type = name, zipfile.ZIP_DEFLATED
            info.external_attr = (0o120777 if link else 0o644) << 16
            file.writestr(info, data)
    return stream.getvalue()


def packed(entry: str) -> bytes:
    body = {"name": "b", "path": "a.su2", "sha256": "", "visible": True, "colour": None}
    body |= {"packed": [entry], "settings": {}}
    return project(bodies=json.dumps([body]), **{entry: MESH})


def array(header: str, data: bytes = bytes(24)) -> bytes:
    head = header.encode()
    npy = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + data
    return project('{"a": {"$array": "arrays/0.npy"}}', **{"arrays/0.npy": npy})


def npy(shape: str = "(3,)", descr: str = "'<f8'", order: str = "False") -> bytes:
    return array(f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n")


def boxed(counts: str, points: int = 0) -> bytes:
    lines = [
        "NDIME= 3",
        "NELEM= 0",
        "NPOIN= 1",
        "0 0 0",
        "NMARK= 0",
        "FFD_NBOX= 1",
        "FFD_NLEVEL= 1",
    ]
    lines += ["FFD_TAG= B", "FFD_LEVEL= 0"]
    lines += [f"FFD_DEGREE_{d}= {n}" for d, n in zip("IJK", counts.split(), strict=True)]
    lines += ["FFD_PARENTS= 0", "FFD_CHILDREN= 0", "FFD_CORNER_POINTS= 8", CORNERS.strip()]
    lines += [f"FFD_CONTROL_POINTS= {points}", "FFD_SURFACE_POINTS= 0", ""]
    return "\n".join(lines).encode()


def cgns(layout: str) -> bytes:
    stream = io.BytesIO()
    with h5py.File(stream, "w", libver="latest") as file:

        def node(parent, name, label, data=None, kind="MT", elsewhere=False):
            group = parent.create_group(name)
            for key, text in (("name", name), ("label", label), ("type", kind)):
                group.attrs[key] = np.bytes_(text)
            if data is None:
                return group
            if elsewhere and layout == "external":
                where = [("../outside.bin", 0, data.nbytes)]
                group.create_dataset(" data", data.shape, data.dtype, external=where)
            elif elsewhere:
                whole = h5py.VirtualLayout(data.shape, data.dtype)
                whole[...] = h5py.VirtualSource("../outside.h5", "x", data.shape)
                group.create_virtual_dataset(" data", whole)
            else:
                group[" data"] = data
            return group

        whole = np.array([3, 3], np.int32)
        base = node(file, "Base", "CGNSBase_t", whole, "I4")
        zone = node(base, "Zone", "Zone_t", np.array([[4], [1], [0]], np.int32), "I4")
        kind = np.frombuffer(b"Unstructured", np.int8)
        node(zone, "ZoneType", "ZoneType_t", kind, "C1")
        grid = node(zone, "GridCoordinates", "GridCoordinates_t")
        for axis in "XYZ":
            node(grid, f"Coordinate{axis}", "DataArray_t", np.zeros(4), "R8", axis == "X")
    return stream.getvalue()


FILES: dict[str, bytes] = {
    "entry_double_slash.ffdproj": packed("meshes/0//tmp/evil.su2"),
    "entry_dots.ffdproj": packed("meshes/0/../../evil.su2"),
    "entry_of_dots_and_blanks.ffdproj": packed("meshes/0/.. /evil.su2"),
    "entry_without_name.ffdproj": project(**{"": b"x"}),
    "entry_link.ffdproj": zipped({"manifest.json": b"{}"}, link=True),
    "nested_lists.ffdproj": project('{"a": ' + "[" * 600 + "]" * 600 + "}"),
    "nested_objects.ffdproj": project('{"a": ' + '{"a":' * 300 + "1" + "}" * 301),
    "npy_true_as_length.ffdproj": npy("(True, 3)"),
    "npy_open_bracket.ffdproj": npy("((("),
    "npy_negative.ffdproj": npy("(-1, -3)"),
    "npy_large.ffdproj": npy(f"({10**15},)"),
    "npy_object.ffdproj": npy(descr="'O'"),
    "npy_fields.ffdproj": npy(descr="[('a', '<f8')]"),
    "npy_calls.ffdproj": npy(order="__import__('os')"),
    "journal_huge_box.jsonl": (HEADER + BOX % "[100000, 100000, 10]").encode(),
    "journal_large_box.jsonl": (HEADER + BOX % "[1000, 1000, 60]").encode(),
    "journal_ragged.jsonl": (
        HEADER + BOX % "[4, 4, 4]" + '{"do": "move points", "item": "lattice1", "points": '
        '[[1, 1], [2, 2, 2]], "positions": [[0, 0, 0]]}\n'
    ).encode(),
    "box_huge.su2": boxed("100000 100000 10"),
    "box_announces.su2": boxed("2 2 2", 10**9),
    "box_without_definition.cfg": b"FFD_DEFINITION= 3\nFFD_DEGREE= 2\n",
    "box_huge.cfg": (
        f"FFD_DEFINITION= (B, {', '.join(CORNERS.split())})\nFFD_DEGREE= (100000, 100000, 10)\n"
    ).encode(),
    "box_polar.cfg": (
        f"FFD_DEFINITION= (B, {', '.join(CORNERS.split())})\nFFD_DEGREE= (2, 2, 2)\n"
        "FFD_COORD_SYSTEM= CYLINDRICAL\n"
    ).encode(),
    "no_points.g2": b"700 1 0 0\n3 0\n0 0\n0 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n",
    "stray_line.prm": b'[Box info]\nn control points x: 2\n" 3 0 1\n=\n',
    "nested.toml": b"x = " + b"[" * 5000,
    "long_integer.toml": CASE.encode() + b"[budget]\niterations = " + b"9" * 5000 + b"\n",
    "dotted.toml": b".".join([b"a"] * 500) + b" = 1\n",
    "extra_number.su2": MESH.replace(b"1 0\n", b"9 1 0\n"),
    "external_storage.cgns": cgns("external"),
    "virtual_storage.cgns": cgns("virtual"),
    "not_closed.tec": b'TITLE = "x"\nVARIABLES = "X", "Y", "Z"\nZONE NODES=4,\nELEMENTS=1,\n',
    "damaged.npz": b"PK\x03\x04" + bytes(60),
    "nested_head.npz": zipped({"head.npy": b"\x93NUMPY\x01\x00\xff\xff" + b"(" * 500}),
}


def main() -> None:
    """Write all of them."""
    for name, data in FILES.items():
        (HERE / name).write_bytes(data)


if __name__ == "__main__":
    main()
