"""What the boundary conditions of a CGNS zone list, and of which kind they are.

1. Points are vertices unless a GridLocation says that they are faces. A range in a structured
   zone then counts faces: one fewer than vertices in the directions along the patch.
2. A condition of kind FamilySpecified has the kind of its family.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.cgns_nodes import Node
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import block_cells
from ffdstudio.meshes.topology import Cells, dimension

KINDS = {
    "Wall": "wall",
    "Symmetry": "symmetry",
    "Farfield": "farfield",
    "Inflow": "inflow",
    "Outflow": "outflow",
}
Parts = dict[str, tuple[Indices, Indices]]  # of a section: type -> nodes and numbers


def families_of(base: Node) -> dict[str, str]:
    """Kind of each family of a base that has one."""
    return {
        family.name: condition.text()
        for family in base.of("Family_t")
        for condition in family.of("FamilyBC_t")
    }


def kind_of(node: Node, families: dict[str, str]) -> str:
    """Our name for the kind of a boundary condition, or CGNS's own."""
    text = node.text()
    if text == "FamilySpecified":
        names = [child.text().rpartition("/")[2] for child in node.of("FamilyName_t")]
        text = next((families[name] for name in names if name in families), text)
    text = text.removeprefix("BC")
    return next((kind for word, kind in KINDS.items() if text.startswith(word)), text)


def _location(node: Node) -> str:
    found = node.child("GridLocation")
    return "Vertex" if found is None else found.text()


def patch(source: Source, node: Node, dims: tuple[int, ...]) -> Cells:
    """Faces of a structured zone that a condition covers; vertices if it lists these."""
    corners, listed = node.child("PointRange"), node.child("PointList")
    if corners is not None and len(corners.values()) == 2 * len(dims):
        ends = corners.values().astype(np.int64).reshape(2, -1)
        low, high = ends.min(axis=0), ends.max(axis=0)
        if "FaceCenter" in _location(node):
            high = high + (np.arange(len(dims)) != _across(node, low, high))
            high = np.minimum(high, dims)  # some writers count vertices in spite of the location
        _check(source, node, np.array([low, high]), dims)
        part = np.ix_(*(np.arange(a - 1, b) for a, b in zip(low[::-1], high[::-1], strict=True)))
        rows = np.arange(int(np.prod(dims))).reshape(dims[::-1])[part].ravel()
        shape = tuple((high - low + 1).tolist())
        return {name: rows[nodes] for name, nodes in block_cells(shape).items()}
    if listed is None or _location(node) != "Vertex" or len(listed.values()) % len(dims):
        return {}
    points = listed.values().astype(np.int64).reshape(-1, len(dims))
    _check(source, node, points, dims)
    strides = np.concatenate([[1], np.cumprod(dims[:-1])])
    return {"vertex": ((points - 1) @ strides)[:, None]}


def _across(node: Node, low: Indices, high: Indices) -> int:
    """Direction across a patch of faces."""
    letter = _location(node)[0]
    return "IJK".index(letter) if letter in "IJK" else int(np.argmin(high - low))


def _check(source: Source, node: Node, points: Indices, dims: tuple[int, ...]) -> None:
    if (points < 1).any() or (points > np.array(dims)).any():
        raise source.failure(f"boundary {node.name} lies outside its zone")


def elements(source: Source, node: Node, sections: list[Parts], count: int) -> Cells:
    """Elements of an unstructured zone that a condition lists, by number or by their vertices.

    Vertices that no element of a section lies between are given as such.
    """
    wanted = _wanted(source, node)
    by_number = any(node.child(f"Element{what}") is not None for what in ("List", "Range"))
    if by_number or _location(node) != "Vertex":
        return _chosen(sections, lambda nodes, numbers: np.isin(numbers, wanted))
    if wanted.size and not (wanted.min() >= 1 and wanted.max() <= count):
        raise source.failure(f"boundary {node.name} refers to a node not in 1 to {count}")
    on = np.zeros(count, dtype=bool)
    on[wanted - 1] = True
    highest = max((dimension(name) for parts in sections for name in parts), default=0)
    lower = [
        {name: part for name, part in parts.items() if dimension(name) == highest - 1}
        for parts in sections
    ]
    found = _chosen(lower, lambda nodes, numbers: np.all(on[nodes], axis=1))
    return found or ({"vertex": np.unique(wanted - 1)[:, None]} if wanted.size else {})


def _chosen(sections: list[Parts], test: Callable[[Indices, Indices], Any]) -> Cells:
    found: dict[str, list[Indices]] = {}
    for parts in sections:
        for name, (nodes, numbers) in parts.items():
            chosen = test(nodes, numbers)
            if chosen.any():
                found.setdefault(name, []).append(nodes[chosen])
    return {name: np.concatenate(nodes) for name, nodes in found.items()}


def _wanted(source: Source, node: Node) -> Indices:
    """Numbers that a condition lists, one by one or as a range."""
    wanted = np.empty(0, dtype=np.int64)
    for name in ("ElementList", "PointList"):
        child = node.child(name)
        if child is not None and child.values().dtype.kind not in "iu":
            raise source.failure(f"boundary {node.name} lists something that is no number")
        wanted = wanted if child is None else child.values().astype(np.int64)
    for name in ("ElementRange", "PointRange"):
        child = node.child(name)
        if child is not None and child.values().dtype.kind not in "iu":
            raise source.failure(f"boundary {node.name} has a range that is no number")
        if child is not None and len(child.values()) == 2:
            low, high = (int(n) for n in child.values())
            if high - low > len(source.data):
                raise source.failure(f"boundary {node.name} has an impossible range")
            wanted = np.arange(low, high + 1)
    return wanted
