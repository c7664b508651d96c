"""Fluent meshes with periodic zones: in text and in binary sections."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.meshes.shapes import block

SHAPE = (3, 2, 2)
AXIS = np.array([0.48, 0.6, 0.64])  # about which the sector turns: no axis of coordinates
ANGLE = np.radians(40.0)


class Zones(NamedTuple):
    """Points, and faces (nodes, first cell, second cell from 1, 0 for none) by zone."""

    points: np.ndarray
    faces: dict[str, list[list[int]]]


def turned(points: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Points turned about AXIS through (1, 2, 3), each by its angle (Rodrigues' formula)."""
    arm = points - [1, 2, 3]
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = (arm @ AXIS)[:, None] * AXIS
    return arm * c + np.cross(AXIS, arm) * s + along * (1 - c) + [1, 2, 3]


def sector() -> Zones:
    """Block bent to a sector: its sides z = 0 and 1 are `low` and `high`, the rest is `hull`."""
    points, cells = block(*SHAPE)
    bent = turned(points * [1, 1, 0] + [3, 0, 0], ANGLE * points[:, 2])
    local = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)]
    seen: dict[tuple, list] = {}
    for cell, nodes in enumerate(cells.tolist(), start=1):
        for face in local:
            corners = [nodes[k] + 1 for k in face]
            seen.setdefault(tuple(sorted(corners)), [corners]).append(cell)
    faces: dict[str, list[list[int]]] = {"inside": [], "low": [], "high": [], "hull": []}
    for corners, *owners in seen.values():
        z = set(points[np.array(corners) - 1, 2].tolist())
        side = {(0.0,): "low", (1.0,): "high"}.get(tuple(z), "hull")
        zone = "inside" if len(owners) == 2 else side
        faces[zone].append([*corners, *(owners if len(owners) == 2 else [owners[0], 0])])
    return Zones(bent, faces)


def fluent_sector(path: Path, binary: int = 0, mixed: bool = False) -> None:
    """Sector with shadow zones and their pairs; `binary` is 2 (singles) or 3 (doubles)."""
    points, zones = sector()
    total = sum(map(len, zones.values()))
    prefix = f"{binary}0" if binary else ""

    def section(kind: int, head: str, text: str, raw: bytes) -> bytes:
        opening = f"({prefix}{kind} ({head})(".encode()
        if not binary:
            return opening + b"\n" + text.encode() + b"))\n"
        return opening + raw + f")\nEnd of Binary Section   {prefix}{kind})\n".encode()

    rows = "\n".join(" ".join(map(repr, row)) for row in points.tolist())
    body = points.astype("<f4" if binary == 2 else "<f8").tobytes()
    parts = [
        b'(0 "a comment with \\"(10 (1 1 2 1 3)(\\" in it")\n(2 3)\n',
        f"(10 (0 1 {len(points):x} 0 3))\n(12 (0 1 c 0))\n(13 (0 1 {total:x} 0))\n".encode(),
        section(10, f"1 1 {len(points):x} 1 3", rows, body),
        b"(12 (2 1 c 1 4))\n",
    ]
    first, begins = 1, {}
    for zone, (name, faces) in enumerate(zones.items(), start=3):
        begins[name] = first
        kind = {"inside": 2, "low": 12, "high": 8, "hull": 3}[name]
        listed = [[4, *face] if mixed else face for face in faces]
        text = "\n".join(" ".join(f"{n:x}" for n in face) for face in listed)
        head = f"{zone} {first:x} {first + len(faces) - 1:x} {kind:x} {0 if mixed else 4}"
        parts.append(section(13, head, text, np.array(listed, "<i4").tobytes()))
        first += len(faces)
    centre = {
        name: [points[np.array(f[:4]) - 1].mean(axis=0) for f in zones[name]] for name in zones
    }
    pairs = []
    for k, middle in enumerate(centre["low"]):
        goal = turned(middle[None], np.array([ANGLE]))
        partner = int(np.argmin(np.linalg.norm(np.array(centre["high"]) - goal, axis=1)))
        pairs.append(f"{begins['low'] + k:x} {begins['high'] + partner:x}")
    pairs.reverse()  # in no order of the zones
    joined = "\n".join(pairs)
    parts.append(f"(18 (1 {len(pairs):x} 4 5)(\n{joined}))\n".encode())
    names = ["2 fluid air", "3 interior inside", "4 periodic low", "5 shadow high", "6 wall hull"]
    parts += [f"(45 ({name})())\n".encode() for name in names]
    path.write_bytes(b"".join(parts))


def fluent_hdf(path: Path, names: bool = True, zones: int = 1, **storage) -> None:
    """The same sector in HDF5, its nodes in so many zones."""
    import h5py

    points, faces = sector()
    rows = [row for part in faces.values() for row in part]
    sizes = [len(part) for part in faces.values()]
    ends = np.cumsum(sizes)
    with h5py.File(path, "w") as file:
        file.create_group("settings")
        mesh = file.create_group("meshes/1")
        counts = {"dimension": 3, "node": len(points), "face": len(rows), "cell": 12}
        mesh.attrs["dimension"] = np.array([3], np.int32)
        for key in ("node", "face", "cell"):
            mesh.attrs[f"{key}Offset"] = np.array([1], np.uint64)
            mesh.attrs[f"{key}Count"] = np.array([counts[key]], np.uint64)

        def limited(item, first, last):
            item.attrs["minId"] = np.array([first], np.uint64)
            item.attrs["maxId"] = np.array([last], np.uint64)

        def table(where, **columns):
            group = mesh.create_group(f"{where}/zoneTopology")
            group.attrs["nZones"] = np.array([len(columns["id"])], np.uint64)
            for key, values in columns.items():
                wide = key in ("minId", "maxId", "dimension")
                group[key] = np.array(values, np.uint64 if wide else np.int32)
            return group

        parts = np.array_split(np.arange(len(points)), zones)
        limits = [(part[0] + 1, part[-1] + 1) for part in parts]
        low, high = zip(*limits, strict=True)
        table("nodes", id=range(1, zones + 1), minId=low, maxId=high, dimension=[3] * zones)
        for k, part in enumerate(parts, start=1):
            item = mesh.create_dataset(f"nodes/coords/{k}", data=points[part], **storage)
            limited(item, part[0] + 1, part[-1] + 1)
        table("cells", id=[2], minId=[1], maxId=[12], dimension=[3], cellType=[4], childZoneId=[0])
        topology = table(
            "faces",
            id=[3, 4, 5, 6],
            minId=ends - sizes + 1,
            maxId=ends,
            dimension=[2] * 4,
            zoneType=[2, 12, 8, 3],
            faceType=[4] * 4,
            childZoneId=[0] * 4,
            shadowZoneId=[0, 5, 4, 0],
            flags=[0] * 4,
        )
        if names:
            topology["name"] = np.array([b"inside;low;high;hull"])
        listed = mesh.create_group("faces/nodes/1")
        mesh["faces/nodes"].attrs["nSections"] = np.array([1], np.uint64)
        limited(listed, 1, len(rows))
        listed["nnodes"] = np.full(len(rows), 4, np.int16)
        listed["nodes"] = np.array([row[:4] for row in rows], np.uint32).ravel()
        for k, key in ((4, "c0"), (5, "c1")):
            many = len(rows) if key == "c0" else sizes[0]  # outside there is no second cell
            item = mesh.create_dataset(
                f"faces/{key}/1", data=np.array([row[k] for row in rows[:many]], np.uint32)
            )
            limited(item, 1, many)
            mesh[f"faces/{key}"].attrs["nSections"] = np.array([1], np.uint64)
