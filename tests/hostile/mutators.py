"""Mutations that know the structure of a container: its parts stay readable while they lie.

Each takes a generator of random numbers and the content of a file, and returns another content.
What a byte-wise mutation breaks at once (a checksum, a bracket, an offset) stays right here, so
that the code behind it is reached.
"""

from __future__ import annotations

import contextlib
import copy
import io
import json
import re
import struct
import tomllib
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tests.meshes.test_fuzz import mutated as bytewise

Rng = np.random.Generator
Mutator = Callable[[Rng, bytes], bytes]
VICTIM = 12345.678  # what no file of ours may ever show: it stands in a file outside the folder

VALUES: list[Any] = [
    None, True, False, 0, -1, 1, 2, 1e308, -1e308, 5e-324, 10**40, 2**31, 2**63, 0.5, "", "x",
    "x" * 2000, "../../x", "/etc/passwd", "//host/share", "\x00", "\u202e", [], {}, [[]], [0] * 50,
    [[1, 2], [3]], {"$array": "arrays/0.npy"}, {"$lattice": {}}, {"": {}}, "NaN",
]  # fmt: skip
NUMBERS = [b"0", b"-1", b"1e999", b"nan", b"4294967297", b"99999999999999999999", b"x", b"", b"2"]
NAMES = [
    "../evil", "/etc/evil", "a//b", "meshes/0//etc/evil", "meshes/0/../../x", "a\\b", "c:x", "",
    ".",
    "meshes/0/a.su2", "manifest.json", "arrays/0.npy", "a/" * 300 + "b", "\u202etxt",
]  # fmt: skip


def pick(rng: Rng, items: list[Any]) -> Any:
    """One of several things."""
    return items[int(rng.integers(len(items)))]


# ---- trees of JSON and TOML ----------------------------------------------------------------------


def tree(rng: Rng, value: Any) -> Any:
    """A nested value with something in it changed."""
    places = list(_places(value))
    if not places:
        return copy.deepcopy(pick(rng, VALUES))
    holder, key = pick(rng, places)
    match rng.integers(0, 6):
        case 0:
            del holder[key]
        case 1:
            holder[key] = copy.deepcopy(pick(rng, VALUES))
        case 2:
            other, name = pick(rng, places)
            holder[key] = copy.deepcopy(other[name])
        case 3:
            for _ in range(int(rng.integers(1, 100))):
                holder[key] = [holder[key]]
        case 4 if isinstance(holder, dict):
            holder[pick(rng, ["x", "", "$array", "do", "name", key + "_"])] = holder[key]
        case _:
            if isinstance(holder[key], list) and holder[key]:
                holder[key] = holder[key] * int(rng.integers(2, 5))
            else:
                holder[key] = [holder[key]]
    return value


def _keys(holder: Any) -> Any:
    return holder if isinstance(holder, dict) else range(len(holder))


def _places(value: Any, depth: int = 0) -> Any:
    if depth > 60 or not isinstance(value, dict | list):
        return
    for key in list(_keys(value)):
        yield value, key
        yield from _places(value[key], depth + 1)


def json_file(rng: Rng, data: bytes) -> bytes:
    """One object."""
    try:
        value = json.loads(data)
    except (ValueError, RecursionError):
        return bytewise(rng, data)
    for _ in range(rng.integers(1, 4)):
        value = tree(rng, value)
    return _dumped(rng, value)


def _dumped(rng: Rng, value: Any) -> bytes:
    try:
        text = json.dumps(value)
    except (RecursionError, ValueError):
        return b"{}"
    if rng.integers(8) == 0:
        text = text.replace(": ", f": {pick(rng, ['NaN', 'Infinity', '1e999', '[' * 200])}, ", 1)
    if rng.integers(8) == 0:
        text = text.replace("{", '{"format": 1, ', 1)
    return text.encode("utf-8", "replace")


def json_lines(rng: Rng, data: bytes) -> bytes:
    """One object a line: journals and logs."""
    lines = data.split(b"\n")
    for _ in range(rng.integers(1, 4)):
        k = int(rng.integers(len(lines)))
        match rng.integers(0, 4):
            case 0:
                lines.insert(k, lines[k])
            case 1:
                j = int(rng.integers(len(lines)))
                lines[k], lines[j] = lines[j], lines[k]
            case _:
                lines[k] = json_file(rng, lines[k]) if lines[k].strip() else b"{}"
    return b"\n".join(lines)


def toml_file(rng: Rng, data: bytes) -> bytes:
    """Tables."""
    try:
        value = tomllib.loads(data.decode())
    except ValueError:
        return bytewise(rng, data)
    for _ in range(rng.integers(1, 4)):
        value = tree(rng, value)
    if not isinstance(value, dict):
        value = {"shape": value}
    lines = []
    for name, table in value.items():
        with contextlib.suppress(RecursionError):  # nested too deeply to be written at all
            lines.append(f"{json.dumps(name)} = {_toml(table)}")
    if rng.integers(10) == 0:
        lines.append(pick(rng, ["x = " + "[" * 1000, "a." * 300 + "a = 1", "y = " + "9" * 5000]))
    return "\n".join([*lines, ""]).encode("utf-8", "replace")


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {_toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float) and not np.isfinite(value):
        return "nan"
    return '""' if value is None else json.dumps(value)


# ---- .npy and zip --------------------------------------------------------------------------------

SHAPES = [
    "()",
    "(0,)",
    "(3,)",
    "(-1,)",
    "(True, 3)",
    f"({10**15},)",
    "(2, 0, 3)",
    "(((3,",
    "(1, " * 40,
]
KINDS = [
    "'<f8'",
    "'>f8'",
    "'<f4'",
    "'O'",
    "'<U9'",
    "'|b1'",
    "'<i8'",
    "'V8'",
    "[('a', '<f8')]",
    "'<f3'",
]


def npy_file(rng: Rng, data: bytes) -> bytes:
    """A header of one line, then the numbers."""
    begin = 10 + int.from_bytes(data[8:10], "little")
    head, rest = data[10:begin].decode("latin-1"), data[begin:]
    match rng.integers(0, 7):
        case 0:
            head = re.sub(r"'shape': \([^)]*\)", f"'shape': {pick(rng, SHAPES)}", head)
        case 1:
            head = re.sub(r"'descr': '[^']*'", f"'descr': {pick(rng, KINDS)}", head)
        case 2:
            head = head.replace("False", pick(rng, ["True", "1", "None", "open('x')"]))
        case 3:
            rest = rest[: int(rng.integers(len(rest) + 1))]
        case 4:
            rest = pick(rng, [struct.pack("<d", x) for x in (np.nan, np.inf, 1e308, 0)]) + rest[8:]
        case 5:
            head = head * int(rng.integers(2, 300))
        case _:
            head = bytewise(rng, head.encode("latin-1")).decode("latin-1")
    raw = head.encode("latin-1")[:65535]
    version = pick(rng, [b"\x01\x00"] * 9 + [b"\x02\x00"])
    return b"\x93NUMPY" + version + len(raw).to_bytes(2, "little") + raw + rest


def zip_file(rng: Rng, data: bytes) -> bytes:
    """Entries by name; what is in them is mutated by their suffix."""
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        entries = [(name, file.read(name)) for name in file.namelist()]
    method, bits, link = zipfile.ZIP_DEFLATED, 0, False
    for _ in range(rng.integers(1, 3)):
        k = int(rng.integers(len(entries)))
        name, content = entries[k]
        match rng.integers(0, 9):
            case 0:
                entries[k] = (pick(rng, NAMES), content)
            case 1:
                entries.append((name, content))
            case 2 if len(entries) > 1:
                del entries[k]
            case 3:
                other = int(rng.integers(len(entries)))
                entries[k], entries[other] = (name, entries[other][1]), (entries[other][0], content)
            case 4:
                method = pick(rng, [zipfile.ZIP_STORED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
            case 5:
                bits, link = int(rng.integers(2)), bool(rng.integers(2))
            case _:
                entries[k] = (name, inner(rng, name, content))
    return _lying(rng, _zipped(entries, method, link), bits)


def inner(rng: Rng, name: str, content: bytes) -> bytes:
    """An entry mutated as what its name says."""
    if name.endswith(".json"):
        return json_file(rng, content)
    return npy_file(rng, content) if name.endswith(".npy") else bytewise(rng, content)


def _zipped(entries: list[tuple[str, bytes]], method: int, link: bool) -> bytes:
    import warnings

    stream = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(stream, "w", method) as file:
        warnings.simplefilter("ignore")  # of names that are there twice
        for name, content in entries:
            info = zipfile.ZipInfo(name or "x")
            info.filename, info.compress_type = name, method
            info.external_attr = (0o120777 if link else 0o644) << 16
            file.writestr(info, content)
    return stream.getvalue()


def _lying(rng: Rng, data: bytes, encrypted: int) -> bytes:
    """Wrong sizes, flags or offsets in the directory, now and then."""
    out, at = bytearray(data), data.find(b"PK\x01\x02")
    if at < 0:
        return data
    if encrypted:
        out[at + 8] |= 1
    if rng.integers(4) == 0:
        place = at + int(pick(rng, [16, 20, 24, 28, 42]))
        out[place : place + 4] = int(rng.integers(0, 2**32)).to_bytes(4, "little")
    return bytes(out)


# ---- XML -----------------------------------------------------------------------------------------

ATTRIBUTE = re.compile(rb'([\w:]+)="([^"]*)"')
WORDS = [
    b"", b"0", b"-1", b"99999999999", b"Float64", b"Int8", b"String", b"binary", b"ascii",
    b"appended", b"raw", b"vtkZLibDataCompressor", b"nan", b"../../etc/passwd", b"BigEndian",
    b"1 2",
]  # fmt: skip


def xml_file(rng: Rng, data: bytes) -> bytes:
    """Elements and attributes; the ends of elements stay where they belong."""
    for _ in range(rng.integers(1, 4)):
        data = _xml_once(rng, data)
    return data


def _xml_once(rng: Rng, data: bytes) -> bytes:
    head = data.find(b"<AppendedData")
    text, tail = (data, b"") if head < 0 else (data[:head], data[head:])
    attributes = list(ATTRIBUTE.finditer(text))
    elements = list(re.finditer(rb"<(\w+)[^<>]*?/>|<(\w+)[^<>]*>[^<]*</\2>", text))
    match rng.integers(0, 8):
        case 0 if elements:
            one = pick(rng, elements)
            text = text[: one.start()] + text[one.end() :]
        case 1 if elements:
            one = pick(rng, elements)
            text = text[: one.start()] + one[0] * int(rng.integers(2, 6)) + text[one.end() :]
        case 2 if len(elements) > 1:
            one, other = sorted((pick(rng, elements) for _ in range(2)), key=lambda m: m.start())
            if one.end() <= other.start():
                middle = text[one.end() : other.start()]
                text = text[: one.start()] + other[0] + middle + one[0] + text[other.end() :]
        case 3:
            entity = (
                b'<!DOCTYPE x [<!ENTITY a "' + b"y" * 50 + b'"><!ENTITY b SYSTEM "/etc/passwd">]>'
            )
            text = entity + text.replace(b"</", b"&a;&b;</", 1)
        case 4 if elements:
            one, deep = pick(rng, elements), int(rng.integers(1, 500))
            nested = b"<Piece>" * deep + one[0] + b"</Piece>" * deep
            text = text[: one.start()] + nested + text[one.end() :]
        case 5 if elements:
            one = pick(rng, elements)
            text = text[: one.start()] + bytewise(rng, one[0]) + text[one.end() :]
        case _ if attributes:
            one = pick(rng, attributes)
            value = pick(rng, [*WORDS, *NUMBERS, pick(rng, attributes)[2]])
            text = text[: one.start(2)] + value + text[one.end(2) :]
    return text + tail


# ---- HDF5 ----------------------------------------------------------------------------------------


def hdf5_file(rng: Rng, data: bytes, victim: Path | None = None) -> bytes:
    """Groups, datasets and attributes; data may come to lie in another file, the victim."""
    stream = io.BytesIO(data)
    try:
        with h5py.File(stream, "r+") as file:
            for _ in range(rng.integers(1, 3)):
                _hdf5_once(rng, file, victim)
    except (OSError, ValueError, RuntimeError, KeyError, TypeError, OverflowError):
        return bytewise(rng, data)
    return stream.getvalue()


def _hdf5_once(rng: Rng, file: Any, victim: Path | None) -> None:
    names: list[str] = []
    file.visit(names.append)
    name = pick(rng, names)
    parent, own = file[name].parent, name.rpartition("/")[2]
    item = file[name]
    attributes = dict(item.attrs)
    where = str(victim or "/nowhere/victim.bin")
    choice = int(rng.integers(0, 10))
    if choice == 0:
        del parent[own]
        return
    if choice == 1 and attributes:
        item.attrs[pick(rng, list(attributes))] = pick(
            rng, [0, -1, "x", np.bytes_("LK"), np.zeros(3), np.bytes_("Zone_t"), 1e300]
        )
        return
    if choice == 2 and attributes:
        del item.attrs[pick(rng, list(attributes))]
        return
    if choice == 3:
        other = pick(rng, names)
        if not other.startswith(name) and not name.startswith(other):
            file.move(name, f"{name}_moved")
        return
    if choice == 4:
        parent[own + "_loop"] = h5py.SoftLink(pick(rng, ["/", f"/{name}", "/nothing"]))
        return
    if not isinstance(item, h5py.Dataset):
        return
    shape, kind = item.shape or (1,), item.dtype
    del parent[own]
    if choice == 5:
        size = int(np.prod(shape)) * kind.itemsize
        parent.create_dataset(own, shape, kind, external=[(where, 0, size)])
    elif choice == 6:
        whole = h5py.VirtualLayout(shape, kind)
        whole[...] = h5py.VirtualSource(where, "x", shape)
        parent.create_virtual_dataset(own, whole)
    elif choice == 7:
        parent[own] = h5py.ExternalLink(where, "x")
        return
    elif choice == 8:
        big = pick(rng, [(10**6, 10**6), (0,), (1,), (3, 3, 3), (10**9,)])
        parent.create_dataset(own, big, pick(rng, ["f8", "i1", "S5", "f4"]), chunks=True)
    else:
        values = pick(
            rng, [np.full(3, np.nan), np.arange(5), np.bytes_("text"), np.zeros((0, 3)), -1]
        )
        parent[own] = values
    for key, value in attributes.items():
        if key not in ("DIMENSION_LIST", "REFERENCE_LIST"):
            parent[own].attrs[key] = value


def for_name(name: str) -> Mutator:
    """The mutator that knows what a file of that name consists of."""
    suffix = name.rpartition(".")[2].lower()
    return {
        "ffdproj": zip_file, "npz": zip_file, "jsonl": json_lines, "json": json_file,
        "toml": toml_file, "npy": npy_file, "vtu": xml_file, "vtp": xml_file, "vts": xml_file,
        "xdmf": xml_file, "cgns": hdf5_file, "exo": hdf5_file, "h5": hdf5_file,
    }.get(suffix, bytewise)  # fmt: skip
