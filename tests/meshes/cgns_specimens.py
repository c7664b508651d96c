"""CGNS files as trees of nodes, written as HDF5 and as ADF of both database versions."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.meshes.shapes import block

KINDS = {"i4": "I4", "i8": "I8", "f4": "R4", "f8": "R8", "i1": "C1"}


class Item(NamedTuple):
    """A node: data as numpy has it (the last index fastest), None without."""

    name: str
    label: str
    data: np.ndarray | None = None
    children: tuple[Item, ...] = ()


def text(value: str) -> np.ndarray:
    return np.frombuffer(value.encode(), np.int8)


def ints(*values: int) -> np.ndarray:
    return np.array(values, np.int32)


def version(number: float) -> Item:
    return Item("CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([number], np.float32))


def kind_of(data: np.ndarray | None) -> str:
    return "MT" if data is None else KINDS[data.dtype.str[1:]]


def as_hdf5(path: Path, items: list[Item], **storage) -> None:
    import h5py

    def add(group, item: Item) -> None:
        own = group.create_group(item.name)
        kind = kind_of(item.data)
        texts = (("name", item.name, 33), ("label", item.label, 33), ("type", kind, 3))
        for key, value, size in texts:
            own.attrs.create(key, np.bytes_(value), dtype=f"S{size}")
        if item.data is not None:
            own.create_dataset(" data", data=item.data, **storage)
        for child in item.children:
            add(own, child)

    with h5py.File(path, "w") as file:
        for item in items:
            add(file, item)


def as_adf(path: Path, items: list[Item], binary: bool = True, order: str = "<") -> None:
    """ADF file, its pointers and lengths as binary numbers (database version B) or as text (A)."""
    out = bytearray(4096)
    out[:4] = bytes.fromhex("c0a8a3a9")
    letter = b"B" if binary else b"A"
    head = b"ADF Database Version " + letter + b"02012>AdF0" + b"Fri Nov 27 17:55:27 2026".ljust(28)
    head += b"AdF1" + b"Fri Nov 27 17:55:27 2026".ljust(28) + b"AdF2"
    head += (b"LL" if order == "<" else b"BB") + b"AdF3010204080408080808080808AdF4"
    out[4 : 4 + len(head)] = head

    def number(value: int, width: int = 8) -> bytes:
        return struct.pack(order + "Q", value) if binary else f"{value:0{width}X}".encode()

    def pointer(at: int) -> bytes:
        if binary:
            return struct.pack(order + "QI", at // 4096, at % 4096)
        return f"{at // 4096:08X}{at % 4096:04X}".encode()

    def put(item: Item) -> int:
        places = [put(child) for child in item.children]
        table = none = pointer(2**20)
        if places:
            table = pointer(len(out))
            names = [child.name.encode().ljust(32) for child in item.children]
            rows = [name + pointer(p) for name, p in zip(names, places, strict=True)]
            size = 16 + 44 * len(rows)
            out.extend(b"SNTb" + pointer(len(out) + size) + b"".join(rows) + b"snTE")
        data, dims, where = b"", (), none
        if item.data is not None:
            dims = item.data.shape[::-1]
            data = item.data.astype(item.data.dtype.newbyteorder(order)).tobytes()
            where = pointer(len(out))
            out.extend(b"DaTa" + pointer(len(out) + 16 + len(data)) + data + b"dEnD")
        at = len(out)
        node = b"NoDe" + item.name.encode().ljust(32) + item.label.encode().ljust(32)
        node += f"{len(places):08X}{len(places):08X}".encode() + table
        node += kind_of(item.data).encode().ljust(32) + f"{len(dims):02X}".encode()
        node += b"".join(map(number, [*dims, *[0] * (12 - len(dims))]))
        node += f"{int(item.data is not None):04X}".encode() + where + b"TaiL"
        assert len(node) == 246
        out.extend(node)
        return at

    root = put(Item("ADF MotherNode", "Root Node of ADF File", None, tuple(items)))
    tail = pointer(root) + pointer(len(out)) + pointer(186) + pointer(0) + b"AdF5fCbt"
    out[len(head) + 4 : len(head) + 4 + len(tail)] = tail
    out[186:190] = b"fCbt"
    path.write_bytes(out)


def hexa_zone(families: dict[str, str] | None = None, shift: int = 0) -> list[Item]:
    """Unstructured block of bricks whose two ends are sections of faces with conditions.

    `families` maps the name of a condition to its family; `shift` is added to the number of the
    element type.
    """
    points, cells = block(3, 2, 2)
    coordinates = points + 0.01 * np.sin(7 * points[:, ::-1])
    ends = [cells[:4, [0, 4, 7, 3]], cells[-4:, [1, 2, 6, 5]]]
    sections = [("Hexa", 17 + shift, cells), ("low faces", 7, ends[0]), ("high faces", 7, ends[1])]
    items, last = [], 0
    for name, number, nodes in sections:
        limits = Item("ElementRange", "IndexRange_t", ints(last + 1, last + len(nodes)))
        flat = Item("ElementConnectivity", "DataArray_t", (nodes + 1).ravel().astype("i4"))
        items.append(Item(name, "Elements_t", ints(number, 0), (limits, flat)))
        last += len(nodes)
    many = len(cells)
    conditions = []
    for name, first in (("bc-1", many + 1), ("bc-2", many + 5)):
        family = (families or {}).get(name)
        own = [Item("PointRange", "IndexRange_t", np.array([[first], [first + 3]], np.int32))]
        own.append(Item("GridLocation", "GridLocation_t", text("FaceCenter")))
        if family:
            own.append(Item("FamilyName", "FamilyName_t", text(family)))
        kind = text("FamilySpecified" if family else "BCWall")
        conditions.append(Item(name, "BC_t", kind, tuple(own)))
    arrays = [
        Item(f"Coordinate{axis}", "DataArray_t", column.copy())
        for axis, column in zip("XYZ", coordinates.T, strict=True)
    ]
    zone = Item(
        "Zone 1",
        "Zone_t",
        np.array([[len(points)], [many], [0]], np.int32),
        (
            Item("ZoneType", "ZoneType_t", text("Unstructured")),
            Item("GridCoordinates", "GridCoordinates_t", None, tuple(arrays)),
            *items,
            Item("ZoneBC", "ZoneBC_t", None, tuple(conditions)),
        ),
    )
    found = [
        Item(name, "Family_t", None, (Item("FamBC", "FamilyBC_t", text("BCWallViscous")),))
        for name in dict.fromkeys((families or {}).values())
    ]
    base = Item("Base", "CGNSBase_t", ints(3, 3), (*found, zone))
    return [version(3.4), base]


SHAPE = (4, 3, 2)


def positions(ranges: list[range], shift: float = 0.0) -> np.ndarray:
    """(k, j, i, 3) points of a block of whole coordinates, sheared so that no axis is alone."""
    k, j, i = np.meshgrid(*reversed(ranges), indexing="ij")
    return np.stack([i + shift + 0.1 * j, j + 0.125 * k, k + 0.0 * i], axis=-1).astype(float)


def structured(blocks: list[dict]) -> list[Item]:
    """Structured zones from dictionaries: name, points (k, j, i, 3), rind, links, conditions."""
    zones = []
    for own in blocks:
        points, rind = own["points"], own.get("rind", ())
        dims = np.array(points.shape[2::-1]) - np.array(rind or [0] * 6).reshape(3, 2).sum(axis=1)
        arrays = [
            Item(f"Coordinate{axis}", "DataArray_t", np.ascontiguousarray(points[..., n]))
            for n, axis in enumerate("XYZ")
        ]
        if rind:
            arrays.append(Item("Rind", "Rind_t", ints(*rind)))
        children = [
            Item("ZoneType", "ZoneType_t", text("Structured")),
            Item("GridCoordinates", "GridCoordinates_t", None, tuple(arrays)),
            Item("ZoneBC", "ZoneBC_t", None, tuple(_conditions(own.get("conditions", {})))),
            Item("ZoneGridConnectivity", "ZoneGridConnectivity_t", None, tuple(_links(own))),
        ]
        sizes = np.array([dims, dims - 1, 0 * dims], np.int32)
        zones.append(Item(own["name"], "Zone_t", sizes, tuple(children)))
    return [version(3.4), Item("Base", "CGNSBase_t", ints(3, 3), tuple(zones))]


def _conditions(given: dict[str, list]) -> Iterator[Item]:
    for name, (family, low, high) in given.items():
        limits = Item("PointRange", "IndexRange_t", np.array([low, high], np.int32))
        yield Item(
            name, "BC_t", text("BCWall"), (limits, Item("FamilyName", "FamilyName_t", text(family)))
        )


def _links(own: dict) -> Iterator[Item]:
    for name, (donor, ends, others, turn) in own.get("links", {}).items():
        children = [
            Item("PointRange", "IndexRange_t", np.array(ends, np.int32)),
            Item("PointRangeDonor", "IndexRange_t", np.array(others, np.int32)),
        ]
        if turn:
            children.append(Item("Transform", '"int[IndexDimension]"', ints(*turn)))
        yield Item(name, "GridConnectivity1to1_t", text(donor), tuple(children))
