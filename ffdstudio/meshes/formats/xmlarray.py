"""The data arrays of VTK's XML files: where they stand, and how to take them out and put back.

1. Raw appended data is no XML, so tags are found here by their brackets, up to that data.
2. An array is text, base64 or raw bytes; inline or appended; whole or in compressed blocks.
   ``decode`` gives the plain bytes, ``encode`` what stands in the file for other bytes.
3. A compressed array is repacked block by block; blocks without a change keep their bytes.
   The offsets of appended arrays behind it move with its size.
"""

from __future__ import annotations

import base64
import binascii
import lzma
import re
import zlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ffdstudio.aliases import AnyArray, Indices
from ffdstudio.meshes.formats.number_table import pick_numbers, split_tokens
from ffdstudio.meshes.formats.source import Source

LZ4 = "vtkLZ4DataCompressor"
COMPRESSORS = ("vtkZLibDataCompressor", "vtkLZMADataCompressor", LZ4)
TYPES = {"Int": "i", "UInt": "u", "Float": "f"}
_TAG = re.compile(rb"<(/?)([A-Za-z]\w*)((?:[^<>\"']|\"[^\"]*\"|'[^']*')*?)(/?)>")
_ATTRIBUTE = re.compile(rb"([A-Za-z_]\w*)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")


@dataclass
class Tag:
    """An element of the file: its name, attributes with their places, and what is inside."""

    name: str
    attributes: dict[str, tuple[str, int]]
    begin: int  # of what is inside
    end: int = 0
    children: list[Tag] = field(default_factory=list)

    def get(self, name: str, default: str = "") -> str:
        """Value of an attribute."""
        return self.attributes.get(name, (default, 0))[0]

    def all(self, name: str) -> list[Tag]:
        """Elements of that name at any depth."""
        own = [child for child in self.children if child.name == name]
        return own + [tag for child in self.children for tag in child.all(name)]

    def child(self, name: str) -> Tag | None:
        """First element of that name directly inside."""
        return next((child for child in self.children if child.name == name), None)


def parse(source: Source) -> Tag:
    """Elements of the file, up to appended data.

    Raises
    ------
    InputError
        If elements do not close in order.
    """
    root = Tag("", {}, 0, len(source.data))
    open_tags, at = [root], source.data.find(b"<")
    while at >= 0:
        comment = source.data.startswith((b"<!--", b"<?"), at)
        match = None if comment else _TAG.match(source.data, at)
        if match is None:
            end = source.data.find(b"-->" if source.data.startswith(b"<!--", at) else b">", at)
            if not comment or end < 0:
                raise source.error(at, "this is no XML element")
            at = source.data.find(b"<", end)
            continue
        at = source.data.find(b"<", match.end())
        if match[1]:
            if len(open_tags) < 2 or open_tags[-1].name != match[2].decode():
                raise source.error(match.start(), f"</{match[2].decode()}> closes nothing")
            open_tags.pop().end = match.start()
            continue
        tag = _opened(match)
        open_tags[-1].children.append(tag)
        if len(open_tags) > 50:
            raise source.error(match.start(), "elements are nested too deep")
        if tag.name == "AppendedData":
            return root
        if not match[4]:
            open_tags.append(tag)
    if len(open_tags) > 1:
        raise source.failure(f"the file ends within <{open_tags[-1].name}>")
    return root


def _opened(match: re.Match[bytes]) -> Tag:
    attributes = {}
    for found in _ATTRIBUTE.finditer(match[3]):
        group = 2 if found[2] is not None else 3
        place = match.start(3) + found.start(group)
        attributes[found[1].decode()] = (found[group].decode("utf-8", "replace"), place)
    return Tag(match[2].decode(), attributes, match.end(), match.end())


@dataclass
class ArrayLayout:
    """What holds for all arrays of a file."""

    source: Source
    order: str
    header: np.dtype
    compressor: str
    appended: int  # place behind the underscore, -1 without appended data
    is_base64: bool  # of the appended data

    @classmethod
    def of(cls, source: Source, root: Tag) -> ArrayLayout:
        """Read it from the first element."""
        top = root.child("VTKFile")
        if top is None:
            raise source.failure("there is no element VTKFile")
        order = ">" if top.get("byte_order") == "BigEndian" else "<"
        header = np.dtype(order + ("u8" if top.get("header_type") == "UInt64" else "u4"))
        appended, is_base64 = -1, False
        for tag in root.all("AppendedData"):
            appended = source.data.find(b"_", tag.begin) + 1 or -1
            is_base64 = tag.get("encoding") == "base64"
        return cls(source, order, header, top.get("compressor"), appended, is_base64)


class DataArray:
    """One array of the file; `count` is how many numbers it must have, if that is known."""

    def __init__(self, layout: ArrayLayout, tag: Tag, count: int | None = None) -> None:
        self.layout, self.tag, self.source, self.count = layout, tag, layout.source, count
        kind = re.fullmatch(r"(Int|UInt|Float)(8|16|32|64)", tag.get("type"))
        if not kind or (kind[1], kind[2]) == ("Float", "8"):
            raise self._error(f"type {tag.get('type')!r} is not supported")
        self.dtype = np.dtype(f"{layout.order}{TYPES[kind[1]]}{int(kind[2]) // 8}")
        self.form = tag.get("format", "ascii")
        if self.form not in ("ascii", "binary", "appended"):
            raise self._error(f"format {self.form!r} is not known")
        self.is_base64 = self.form == "binary" or layout.is_base64
        # numbers may be followed by elements of their own; decode() finds the end of binary data
        self.begin, self.end = tag.begin, self.source.data.find(b"<", tag.begin)
        if self.form == "appended":
            offset = self.source.integer(tag.get("offset").encode(), tag.begin, "offset")
            if layout.appended < 0 or layout.appended + offset > len(self.source.data):
                raise self._error("its appended data is missing")
            self.begin, self.end = layout.appended + offset, len(self.source.data)
        elif self.form == "binary":
            inside = self.source.data[self.begin : self.end]
            self.begin += len(inside) - len(inside.lstrip())
            self.end = self.begin + len(inside.strip())
        self.blocks: list[bytes] = []
        self.head = b""

    def _error(self, message: str) -> Exception:
        name = self.tag.get("Name", "?")
        return self.source.error(self.tag.begin - 1, f"array {name}: {message}")

    def spans(self) -> tuple[Indices, Indices]:
        """Begin and end of every number of an array in text."""
        text = self.source.data[self.begin : self.end]
        starts, ends = split_tokens(text)
        return starts + self.begin, ends + self.begin

    def values(self) -> AnyArray:
        """Numbers of the array, flat."""
        if self.form == "ascii":
            kind = np.float64 if self.dtype.kind == "f" else np.int64
            self._check_size(len(self.spans()[0]) * self.dtype.itemsize)
            return pick_numbers(self.source, *self.spans(), kind)
        plain = self.decode()
        if len(plain) % self.dtype.itemsize:
            raise self._error("its size does not fit its type")
        return np.frombuffer(plain, self.dtype)

    def _check_size(self, size: int) -> None:
        """Raise if the array is not as large as announced, before it is unpacked."""
        found = size // self.dtype.itemsize
        if self.count is not None and size != self.count * self.dtype.itemsize:
            raise self._error(f"{self.count} numbers are announced, it has {found}")

    def decode(self) -> bytes:
        """Plain bytes of a binary array."""
        size = self.layout.header.itemsize
        if not self.layout.compressor:
            length = int(self._header(1)[0])
            self._check_size(length)
            self.head, plain = self._take(size, length)
            self.blocks = [plain]
            return plain
        if self.layout.compressor not in COMPRESSORS:
            raise self._error(f"compressor {self.layout.compressor} is not supported")
        header = self._header(1)
        count = int(header[0])
        if count * size > len(self.source.data):
            raise self._error("it announces more blocks than the file can hold")
        if count == 0:
            self._check_size(0)
            return b""
        header = self._header(3 + count)
        full, last, sizes = int(header[1]), int(header[2]), header[3:].astype(np.int64)
        self._check_size((count - 1) * full + (last or full))
        if (sizes < 0).any() or sizes.sum() > len(self.source.data):
            raise self._error("its blocks are larger than the file")
        self.head, packed = self._take(header.nbytes, int(sizes.sum()), apart=True)
        self.blocks = [packed[e - s : e] for s, e in zip(sizes, np.cumsum(sizes), strict=True)]
        parts = [
            self._unpacked(block, full if k < count - 1 or not last else last)
            for k, block in enumerate(self.blocks)
        ]
        return b"".join(parts)

    def _unpacked(self, block: bytes, size: int) -> bytes:
        if size > 1100 * len(block) + 65536:  # more than deflate can do
            raise self._error("a compressed block claims an impossible size")
        try:
            if self.layout.compressor == LZ4:
                plain = _lz4_unpacked(block, size)
            elif self.layout.compressor == "vtkZLibDataCompressor":
                plain = zlib.decompressobj().decompress(block, size + 1)
            else:
                plain = lzma.LZMADecompressor().decompress(block, size + 1)
        except (zlib.error, lzma.LZMAError, EOFError) as error:
            raise self._error(f"a compressed block is damaged ({error})") from None
        if len(plain) != size:
            raise self._error("a compressed block does not have the size that it states")
        return plain

    def _header(self, count: int) -> AnyArray:
        size = count * self.layout.header.itemsize
        raw = self._raw(self.begin, size)
        return np.frombuffer(raw, self.layout.header)

    def _raw(self, begin: int, size: int) -> bytes:
        """Bytes of the file from a place on, taken out of base64 if need be."""
        if not self.is_base64:
            raw = self.source.data[begin : min(begin + size, self.end)]
        else:
            text = self.source.data[begin : min(begin + -(-size // 3) * 4, self.end)]
            try:
                raw = base64.b64decode(text, validate=True)[:size]
            except binascii.Error:
                raise self._error("its text is not base64") from None
        if len(raw) < size:
            raise self._error("its data ends too early")
        return raw

    def _take(self, head: int, length: int, apart: bool = False) -> tuple[bytes, bytes]:
        """Header and data; in base64 they may be encoded apart. Finds the end of the array."""
        if apart and self.is_base64:
            middle = self.begin + -(-head // 3) * 4
            first, rest = self._raw(self.begin, head), self._raw(middle, length)
            self.end = middle + -(-length // 3) * 4
            return first, rest
        raw = self._raw(self.begin, head + length)
        total = head + length
        self.end = self.begin + (-(-total // 3) * 4 if self.is_base64 else total)
        return raw[:head], raw[head:]

    def encode(self, old: bytes, new: bytes) -> bytes:
        """What stands in the file for new bytes of the same size, unchanged blocks kept."""
        coded = base64.b64encode if self.is_base64 else bytes
        if not self.layout.compressor:
            return coded(self.head + new)
        header = np.frombuffer(self.head, self.layout.header).copy()
        size, packed = int(header[1]), []
        for k, block in enumerate(self.blocks):
            part = slice(k * size, (k + 1) * size)
            same = old[part] == new[part]
            packed.append(block if same else self._packed(new[part]))
        header[3:] = [len(block) for block in packed]
        return coded(header.tobytes()) + coded(b"".join(packed))

    def _packed(self, plain: bytes) -> bytes:
        if self.layout.compressor == "vtkZLibDataCompressor":
            return zlib.compress(plain)
        return _lz4_packed(plain) if self.layout.compressor == LZ4 else lzma.compress(plain)


def _lz4_unpacked(block: bytes, size: int) -> bytes:
    """Block of so many bytes, by VTK's own library; empty if it is damaged."""
    from vtkmodules.vtkIOCore import vtkLZ4DataCompressor

    found = np.empty(max(size, 1), dtype=np.uint8)
    packed = np.frombuffer(block, dtype=np.uint8).copy()
    tool: Any = vtkLZ4DataCompressor()  # its signatures do not know of arrays
    tool.AddObserver("ErrorEvent", lambda caller, event: None)  # told by us, not on the screen
    got = tool.Uncompress(packed, len(block), found, size)
    return found[:size].tobytes() if got == size else b""


def _lz4_packed(plain: bytes) -> bytes:
    from vtkmodules.vtkIOCore import vtkLZ4DataCompressor

    tool: Any = vtkLZ4DataCompressor()
    room = np.empty(tool.GetMaximumCompressionSpace(len(plain)), dtype=np.uint8)
    data = np.frombuffer(plain, dtype=np.uint8).copy()
    return room[: tool.Compress(data, len(plain), room, len(room))].tobytes()
