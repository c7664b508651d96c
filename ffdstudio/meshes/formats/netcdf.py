"""Variables of netCDF files, classic (CDF-1, 2, 5) and HDF5, with the places of their data.

Source: Unidata, "NetCDF classic format specification".
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ffdstudio.aliases import AnyArray
from ffdstudio.errors import InputError
from ffdstudio.meshes.formats.cgns_nodes import HDF_ERRORS, is_inside, opened, values_of
from ffdstudio.meshes.formats.source import Source, decoded

KINDS = {
    1: "i1",
    2: "S1",
    3: ">i2",
    4: ">i4",
    5: ">f4",
    6: ">f8",
    7: "u1",
    8: ">u2",
    9: ">u4",
    10: ">i8",
    11: ">u8",
}
DIMENSIONS, VARIABLES, ATTRIBUTES = 10, 11, 12
ATTRIBUTES_USED = ("elem_type",)  # in a damaged file HDF5 may hang over lists of references


@dataclass
class Variable:
    """A variable; `place` of its data in the file, or -1 where it is in pieces."""

    name: str
    shape: tuple[int, ...]
    dtype: np.dtype
    place: int
    values: AnyArray
    attributes: dict[str, str] = field(default_factory=dict)

    def texts(self) -> list[str]:
        """Rows of characters as text."""
        rows = np.ascontiguousarray(self.values).reshape(-1, self.shape[-1] if self.shape else 1)
        return [decoded(row.tobytes().split(b"\0")[0]).strip() for row in rows]

    def row(self, k: int) -> Variable:
        """Row of a table as a variable of its own."""
        place = -1 if self.place < 0 else self.place + k * self.shape[1] * self.dtype.itemsize
        return Variable(self.name, self.shape[1:], self.dtype, place, self.values[k])


def variables(source: Source) -> dict[str, Variable]:
    """All variables of a file whose shape does not grow.

    Raises
    ------
    InputError
        If it is no netCDF file, is damaged, or h5py is missing for an HDF5 one.
    """
    if source.data.startswith(b"\x89HDF"):
        return _hdf5(source)
    if source.data[:3] != b"CDF" or source.data[3:4] not in (b"\1", b"\2", b"\5"):
        raise source.failure("neither a netCDF nor an HDF5 file")
    return _Classic(source).variables()


class _Classic:
    """Goes through the header of a classic file."""

    def __init__(self, source: Source) -> None:
        self.source = source
        version = source.data[3]
        self.count = 8 if version == 5 else 4
        self.offset = 4 if version == 1 else 8
        self.at = 4 + self.count  # behind the number of records

    def _number(self, size: int) -> int:
        begin, self.at = self.at, self.at + size
        if self.at > len(self.source.data):
            raise self.source.failure("damaged: the file ends within its header")
        return int.from_bytes(self.source.data[begin : self.at], "big")

    def _name(self) -> str:
        size = self._number(self.count)
        begin, self.at = self.at, self.at + -(-size // 4) * 4
        if self.at > len(self.source.data):
            raise self.source.failure("damaged: the file ends within its header")
        return decoded(self.source.data[begin : begin + size])

    def _list(self, kind: int) -> int:
        tag, count = self._number(4), self._number(self.count)
        if (tag not in (kind, 0)) or (tag == 0 and count) or count > len(self.source.data):
            raise self.source.failure("damaged header")
        return count

    def _attributes(self) -> dict[str, str]:
        found = {}
        for _ in range(self._list(ATTRIBUTES)):
            name, kind = self._name(), self._kind()
            size = self._number(self.count) * kind.itemsize
            begin, self.at = self.at, self.at + -(-size // 4) * 4
            if self.at > len(self.source.data):
                raise self.source.failure("damaged: the file ends within its header")
            if kind.kind == "S":
                text = self.source.data[begin : begin + size]
                found[name] = decoded(text).strip(" \0")
        return found

    def _kind(self) -> np.dtype:
        number = self._number(4)
        if number not in KINDS:
            raise self.source.failure(f"damaged: no type {number}")
        return np.dtype(KINDS[number])

    def variables(self) -> dict[str, Variable]:
        sizes = []
        for _ in range(self._list(DIMENSIONS)):
            self._name()
            sizes.append(self._number(self.count))
        self._attributes()
        found = {}
        for _ in range(self._list(VARIABLES)):
            name = self._name()
            many = self._number(self.count)
            if many > len(sizes):
                raise self.source.failure(f"damaged: variable {name} has too many dimensions")
            dims = [self._number(self.count) for _ in range(many)]
            if any(dim >= len(sizes) for dim in dims):
                raise self.source.failure(f"damaged: variable {name} has an unknown dimension")
            attributes, kind = self._attributes(), self._kind()
            self._number(self.count)
            place = self._number(self.offset)
            shape = tuple(sizes[dim] for dim in dims)
            if 0 in shape:  # grows with the records
                continue
            count = int(np.prod([float(n) for n in shape]))
            if place + count * kind.itemsize > len(self.source.data):
                raise self.source.failure(f"variable {name} does not fit the file")
            values = np.frombuffer(self.source.data, kind, count, place).reshape(shape)
            found[name] = Variable(name, shape, kind, place, values, attributes)
        return found


def _hdf5(source: Source) -> dict[str, Variable]:
    import contextlib

    with contextlib.ExitStack() as stack:
        file = stack.enter_context(opened(source))
        try:
            inside = {name: file[name] for name in file if is_inside(file, name)}
            return {
                name: _variable(source, name, item)
                for name, item in inside.items()
                if _is_data(item)
            }
        except HDF_ERRORS as error:
            if isinstance(error, InputError):
                raise
            raise source.failure(f"damaged HDF5 file ({str(error)[:100]})") from error


def _is_data(item: Any) -> bool:
    return hasattr(item, "shape") and item.size is not None and item.dtype.kind in "iufS"


def _variable(source: Source, name: str, item: Any) -> Variable:
    values = values_of(source, item, f"variable {name}")
    offset = item.id.get_offset()
    attributes: dict[str, str] = {}
    for key in (key for key in ATTRIBUTES_USED if key in item.attrs):
        value = item.attrs[key]
        text = decoded(value) if isinstance(value, bytes) else value
        attributes |= {key: text} if isinstance(text, str) else {}
    place = -1 if offset is None else offset
    return Variable(name, item.shape, item.dtype, place, values, attributes)
