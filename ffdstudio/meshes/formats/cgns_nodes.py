"""The tree of named nodes that CGNS files are, in ADF and in HDF5, with the places of the data.

1. ADF writes its pointers and sizes as hexadecimal text, from database version B on as binary
   numbers of the same widths: a node is a record of 246 bytes, its children a table of names
   and pointers, its data a block between two marks. So the place of every array is known
   exactly and nothing has to be searched for.
2. In HDF5 a node is a group and its data the dataset `` data``; where that lies in one piece
   (the rule), its place in the file is known, too. Elsewhere it is written through h5py.

Source: CGNS documentation, "ADF file format" and "SIDS file mapping to HDF5".
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ffdstudio.aliases import AnyArray
from ffdstudio.errors import InputError
from ffdstudio.meshes.formats.source import Source, decoded

TYPES = {
    "I4": "i4",
    "I8": "i8",
    "U4": "u4",
    "U8": "u8",
    "R4": "f4",
    "R8": "f8",
    "C1": "S1",
    "B1": "u1",
}
BLOCK = 4096
HEX = frozenset(b"0123456789abcdefABCDEF")
DEPTH = 30
# what h5py raises on a damaged file
HDF_ERRORS = (OSError, RuntimeError, LookupError, ValueError, TypeError, ArithmeticError)


@dataclass
class Node:
    """A node: `dims` with the fastest index first; `place` of its data in the file, or -1."""

    name: str
    label: str
    dims: tuple[int, ...] = ()
    dtype: np.dtype | None = None
    place: int = -1
    path: str = ""
    children: list[Node] = field(default_factory=list)
    data: AnyArray | None = None

    def of(self, label: str) -> Iterator[Node]:
        """Children with a label."""
        return (child for child in self.children if child.label == label)

    def child(self, name: str) -> Node | None:
        """Child with a name."""
        return next((child for child in self.children if child.name == name), None)

    def values(self) -> AnyArray:
        """Flat data, the fastest index first; empty without data."""
        return np.empty(0, dtype=np.int64) if self.data is None else self.data

    def text(self) -> str:
        """Data as text."""
        return self.values().tobytes().decode("utf-8", "replace").strip(" \0")


class Adf:
    """The nodes of an ADF file."""

    def __init__(self, source: Source) -> None:
        self.source = source
        if len(source.data) < 186 or source.data[96:100] != b"AdF2":
            raise source.failure("neither an ADF nor an HDF5 file: no CGNS?")
        formats = {b"L": "<", b"B": ">"}
        order = source.data[100:101]
        if order not in formats:
            raise source.failure("numbers in this file are neither big nor little end first")
        self.order = formats[order]
        self.is_binary = source.data[4:26] == b"ADF Database Version B"
        self.pointers = self.order  # byte order of pointers
        self.seen: set[int] = set()

    def root(self) -> Node:
        """Read all nodes."""
        at = self.source.data.find(b"AdF4", 96, 200)
        if self.is_binary:  # in the order of the machine or of the data: the root tells
            begins = {order: self._binary(at + 4, order) for order in "<>"}
            fits = [o for o, n in begins.items() if self.source.data[n : n + 4] == b"NoDe"]
            self.pointers = (fits or [self.order])[0]
        return self._node(self._pointer(at + 4), 0)

    def _binary(self, at: int, order: str) -> int:
        """Pointer of eight and four bytes: a block, and a place in it."""
        if at < 0 or at + 12 > len(self.source.data):
            raise self.source.failure(f"damaged: no pointer at byte {at}")
        block, offset = struct.unpack_from(f"{order}QI", self.source.data, at)
        return int(block) * BLOCK + int(offset)

    def _length(self, at: int) -> int:
        """Length of an array along one direction."""
        if not self.is_binary:
            return self._hex(at, 8)
        return int(struct.unpack_from(f"{self.pointers}Q", self.source.data, at)[0])

    def _hex(self, at: int, size: int) -> int:
        text = self.source.data[at : at + size]
        if at < 0 or len(text) < size or not HEX.issuperset(text):
            raise self.source.failure(f"damaged: no hexadecimal number at byte {at}")
        return int(text, 16)

    def _pointer(self, at: int) -> int:
        if self.is_binary:
            return self._binary(at, self.pointers)
        return self._hex(at, 8) * BLOCK + self._hex(at + 8, 4)

    def _mark(self, at: int, mark: bytes) -> None:
        if self.source.data[at : at + 4] != mark:
            raise self.source.failure(f"damaged: no mark {mark.decode()} at byte {at}")

    def _node(self, at: int, depth: int) -> Node:
        self._mark(at, b"NoDe")
        if at in self.seen or depth > DEPTH:
            raise self.source.failure("damaged: a node contains itself")
        self.seen.add(at)
        data = self.source.data
        name, label, kind = (
            decoded(data[at + begin : at + begin + 32]).rstrip(" \0") for begin in (4, 36, 96)
        )
        node = Node(name, label)
        if kind == "LK":
            raise self.source.failure(f"node {name} is a link into another file")
        self._data(node, kind, at)
        count = self._hex(at + 68, 8)
        if count:
            node.children = self._children(self._pointer(at + 84), count, depth)
        return node

    def _children(self, at: int, count: int, depth: int) -> list[Node]:
        self._mark(at, b"SNTb")
        if at + 16 + 44 * count > len(self.source.data):
            raise self.source.failure("damaged: a table of nodes does not fit the file")
        return [self._node(self._pointer(at + 16 + 44 * k + 32), depth + 1) for k in range(count)]

    def _data(self, node: Node, kind: str, at: int) -> None:
        if kind not in TYPES:
            return  # MT: without data
        node.dtype = np.dtype(self.order + TYPES[kind] if kind != "C1" else "S1")
        many = self._hex(at + 128, 2)
        node.dims = tuple(self._length(at + 130 + 8 * k) for k in range(min(many, 12)))
        chunks = self._hex(at + 226, 4)
        if chunks == 0:
            return
        if chunks > 1:
            raise self.source.failure(f"the data of {node.name} is in several pieces")
        begin = self._pointer(at + 230)
        self._mark(begin, b"DaTa")
        count = int(np.prod([float(n) for n in node.dims]))
        if begin + 16 + count * node.dtype.itemsize > len(self.source.data):
            raise self.source.failure(f"the data of {node.name} does not fit the file")
        node.place = begin + 16
        node.data = np.frombuffer(self.source.data, node.dtype, count, node.place)


def hdf5(source: Source) -> Node:
    """Nodes of an HDF5 file.

    Raises
    ------
    InputError
        If h5py is not installed or the file is damaged.
    """
    with opened(source) as file:
        try:
            return _group(source, file, "", 0)
        except HDF_ERRORS as error:
            if isinstance(error, InputError):
                raise
            raise source.failure(f"damaged HDF5 file ({_cause(error)})") from error


def opened(source: Source, mode: str = "r", stream: io.BytesIO | None = None) -> Any:
    """Open the content of a file with h5py."""
    try:
        import h5py
    except ImportError:
        raise source.failure(
            "this file is HDF5, which needs h5py: pip install 'ffdstudio[formats]'"
        ) from None
    try:
        return h5py.File(stream or io.BytesIO(source.data), mode)
    except HDF_ERRORS as error:
        raise source.failure(f"damaged HDF5 file ({_cause(error)})") from error


def _cause(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:100]


def _attribute(group: Any, name: str) -> str:
    value = group.attrs.get(name, b"")
    return decoded(value).strip(" \0") if isinstance(value, bytes) else str(value)


def _group(source: Source, group: Any, path: str, depth: int) -> Node:
    import h5py

    if depth > DEPTH:
        raise source.failure("damaged: groups are nested too deep")
    node = Node(_attribute(group, "name") or path.rpartition("/")[2], _attribute(group, "label"))
    if _attribute(group, "type") == "LK":
        raise source.failure(f"node {node.name} is a link into another file")
    for name in group:
        if not is_inside(group, name):
            continue
        item = group[name]
        if name == " data" and isinstance(item, h5py.Dataset):
            _dataset(source, node, item, f"{path}/ data")
        elif isinstance(item, h5py.Group):
            node.children.append(_group(source, item, f"{path}/{name}", depth + 1))
    return node


def is_inside(group: Any, name: str) -> bool:
    """Whether a member of a group is no link, which may lead into another file or in circles."""
    import h5py

    return isinstance(group.get(name, getlink=True), h5py.HardLink)


def _dataset(source: Source, node: Node, item: Any, path: str) -> None:
    """Take the data of a node; strings are stored as small integers."""
    values = values_of(source, item, f"the data of {node.name}")
    offset = item.id.get_offset()
    node.place = -1 if offset is None else offset
    node.path, node.dtype = path, item.dtype
    node.dims = item.shape[::-1]
    node.data = values.ravel()


def values_of(source: Source, item: Any, what: str) -> AnyArray:
    """Read an HDF5 dataset that lies in its file; every reader of HDF5 reads through here.

    A dataset may name any other file as its storage: reading would then show that file's
    bytes as coordinates, and writing the mesh would overwrite it.

    Raises
    ------
    InputError
        If the data lies in other files, or is larger than the file can make it.
    """
    if item.external or item.is_virtual:
        raise source.failure(f"{what} lies in another file, which is not opened")
    if item.size * item.dtype.itemsize > 20 * len(source.data) + 10_000_000:
        raise source.failure(f"{what} claims an impossible size")
    return np.asarray(item[()])
