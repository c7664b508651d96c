"""The lists in OpenFOAM's mesh files: ASCII, binary and compressed.

A file is a header (FoamFile), then a count and a list in round brackets. Binary lists hold raw
labels or scalars of the widths that the header's ``arch`` names.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffdstudio.aliases import AnyArray, Indices
from ffdstudio.files import read_bytes
from ffdstudio.meshes.compressed import unpacked
from ffdstudio.meshes.formats.number_table import pick_numbers, split_tokens
from ffdstudio.meshes.formats.source import Source, decoded

_HEADER = re.compile(rb"FoamFile\s*\{([^{}]*)\}")
_LIST = re.compile(rb"(\d+)\s*\(")
_SIZE = re.compile(rb"\s*(\d+)\s*\(")
_COMMENT = re.compile(rb"/\*.*?\*/|//[^\n]*", re.S)
_TOKEN = re.compile(rb'"(?:[^"\\]|\\.)*"|[{}();]|[^\s{}();"]+')


@dataclass(frozen=True, eq=False)
class FoamFile:
    """Content of a file, unpacked, with what its header says."""

    source: Source
    raw: bytes  # as on the disk
    begin: int  # behind the header
    is_binary: bool
    label: np.dtype
    scalar: np.dtype

    @classmethod
    def find(cls, folder: Path, name: str) -> FoamFile:
        """Read a file of the mesh or its ``.gz``.

        Raises
        ------
        InputError
            If neither is there or the header is damaged.
        """
        path = folder / name
        if not path.exists() and path.with_name(name + ".gz").exists():
            path = path.with_name(name + ".gz")
        raw = read_bytes(path)
        data = unpacked(path, raw) if path.suffix == ".gz" else raw
        return cls.of(Source(path, data), raw)

    @classmethod
    def of(cls, source: Source, raw: bytes) -> FoamFile:
        """Understand the header."""
        match = _HEADER.search(source.data[:20000])
        if match is None:
            raise source.failure("there is no FoamFile header: not a file of an OpenFOAM mesh?")
        entries = _COMMENT.sub(b"", match[1])
        order = ">" if b"MSB" in entries else "<"
        label = 8 if b"label=64" in entries else 4
        scalar = 4 if b"scalar=32" in entries else 8
        return cls(
            source,
            raw,
            match.end(),
            re.search(rb"format\s+binary", entries) is not None,
            np.dtype(f"{order}i{label}"),
            np.dtype(f"{order}f{scalar}"),
        )

    def list_at(self, place: int) -> tuple[int, int]:
        """Count of the next list and the place behind its opening bracket."""
        at = place
        while True:
            match = _LIST.search(self.source.data, at)
            if match is None:
                raise self.source.failure("there is no list in this file")
            line = self.source.data.rfind(b"\n", place, match.start()) + 1
            comment = self.source.data[max(line, place) : match.start()].lstrip()
            if not comment.startswith((b"//", b"/*", b"|", b"\\")):
                return int(match[1]), match.end()
            at = match.end()

    def binary(self, count: int, begin: int, dtype: np.dtype) -> AnyArray:
        """Raw numbers of a list."""
        if begin + count * dtype.itemsize >= len(self.source.data):
            raise self.source.failure(f"the file ends before its {count} numbers")
        return np.frombuffer(self.source.data, dtype, count, begin)

    def spans(self, begin: int) -> tuple[Indices, Indices]:
        """Places of the numbers of an ASCII list of lists, up to its last bracket."""
        end = self.source.data.rfind(b")")
        starts, ends = split_tokens(self.source.data[begin : max(end, begin)], b"()")
        return starts + begin, ends + begin

    @property
    def is_face_list(self) -> bool:
        """Whether every face is a list of its own, as foam-extend writes them in binary too."""
        return re.search(rb"class\s+faceList\s*;", self.source.data[: self.begin]) is not None

    def _listed_faces(self, count: int, begin: int) -> tuple[Indices, Indices]:
        """Faces of a binary faceList: the size of each, then its labels in brackets."""
        data, width = self.source.data, self.label.itemsize
        parts, sizes = [np.empty(0, dtype=np.int64)], [0]
        for _ in range(count):
            match = _SIZE.match(data, begin)
            if match is None or int(match[1][:9]) * width > len(data) - match.end():
                raise self.source.failure(f"the file ends before its {count} faces")
            size = int(match[1])
            parts.append(np.frombuffer(data, self.label, size, match.end()).astype(np.int64))
            sizes.append(size)
            begin = match.end() + size * width + 1
        return np.concatenate(parts), np.cumsum(sizes, dtype=np.int64)

    def labels(self) -> Indices:
        """List of labels: owner, neighbour."""
        count, begin = self.list_at(self.begin)
        if self.is_binary:
            return self.binary(count, begin, self.label).astype(np.int64)
        found = pick_numbers(self.source, *self.spans(begin), np.int64)
        if len(found) != count:
            raise self.source.failure(f"{count} labels are announced, found {len(found)}")
        return found

    def faces(self) -> tuple[Indices, Indices]:
        """Nodes of all faces and where each face begins."""
        count, begin = self.list_at(self.begin)
        if self.is_binary and self.is_face_list:
            return self._listed_faces(count, begin)
        if self.is_binary:  # two lists: offsets, then nodes
            offsets = self.binary(count, begin, self.label).astype(np.int64)
            many, begin = self.list_at(begin + count * self.label.itemsize)
            nodes = self.binary(many, begin, self.label).astype(np.int64)
            if count == 0 or offsets[0] != 0 or offsets[-1] != many or (np.diff(offsets) < 0).any():
                raise self.source.failure("the offsets of the faces are damaged")
            return nodes, offsets
        starts, ends = self.spans(begin)
        numbers = pick_numbers(self.source, starts, ends, np.int64)
        letters = np.frombuffer(self.source.data, dtype=np.uint8)
        sizes = np.flatnonzero(letters[ends] == ord("("))
        offsets = np.concatenate([[0], np.cumsum(numbers[sizes])])
        fits = len(sizes) == count and np.array_equal(offsets[:-1] + np.arange(count), sizes)
        if not fits or offsets[-1] + count != len(numbers):
            raise self.source.failure(f"these are not {count} faces of the sizes that they state")
        return np.delete(numbers, sizes), offsets


def dictionary(source: Source) -> list[tuple[str, dict[str, str]]]:
    """Entries of a list of dictionaries, such as the boundary file's patches."""
    text = _COMMENT.sub(b" ", source.data)
    text = _HEADER.sub(b"", text)
    found = []
    for name, body in _bodies(source, text):
        words = re.findall(rb"([^\s;]+)\s+([^;]*);", body)
        values = {key.decode("latin-1"): value.strip().decode("latin-1") for key, value in words}
        found.append((decoded(name.strip(b'"')), values))
    return found


def _bodies(source: Source, text: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Names of the outermost dictionaries with what is in them, dictionaries aside."""
    depth, name, pieces, last, at = 0, b"", b"", b"", 0
    for match in _TOKEN.finditer(text):
        token = match[0]
        if token == b"{":
            if depth == 0:
                name, pieces = last, b""
            elif depth == 1:  # the word before a nested dictionary is its name
                pieces = (pieces + text[at : match.start()]).rstrip()[: -len(last) or None]
            depth, at = depth + 1, match.end()
        elif token == b"}":
            if depth == 1:
                yield name, pieces + text[at : match.start()]
            depth, at = max(depth - 1, 0), match.end()
        last = token
    if depth:
        raise source.failure(f"the entry {name.decode('utf-8', 'replace')} does not end")
