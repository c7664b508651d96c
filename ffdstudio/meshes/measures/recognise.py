"""Tetrahedra, pyramids, wedges and hexahedra among the cells of a face-based mesh.

A cell with the right number of triangles and quads is rebuilt from a base face: at each node of
the base the two other faces that meet there tell the third neighbour. Cells where that fails
(more than three faces at a node of the base, faces that do not close) stay polyhedra.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.mesh import Faces

KINDS = {  # triangles, quads, nodes of the base face, distinct nodes beyond the base
    "tetra": (4, 0, 3, 1),
    "pyramid": (4, 1, 4, 1),
    "wedge": (2, 3, 3, 3),
    "hexahedron": (0, 6, 4, 4),
}
Found = dict[str, tuple[Indices, Indices]]


def sides(faces: Faces) -> tuple[Indices, Indices, Indices]:
    """Each face seen from each of its cells, sorted by cell: cell, face, and 1 or -1 (reversed)."""
    inner = np.flatnonzero(faces.neighbour >= 0)
    cell = np.concatenate([faces.owner, faces.neighbour[inner]])
    face = np.concatenate([np.arange(len(faces)), inner])
    sign = np.repeat([1, -1], [len(faces), len(inner)])
    order = np.argsort(cell, kind="stable")
    return cell[order], face[order], sign[order]


def ramps(sizes: Indices) -> Indices:
    """0 to size - 1 for each size, one after the other.

    Examples
    --------
    >>> ramps(np.array([3, 2]))
    array([0, 1, 2, 0, 1])
    """
    ends = np.cumsum(sizes)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - sizes, sizes)


def recognised(faces: Faces) -> tuple[Found, np.ndarray]:
    """Cells by type as (nodes, cell numbers), and a mask of the cells that are none of these."""
    cell, face, sign = sides(faces)
    size = np.diff(faces.offsets)[face]
    count, triangles, quads = (
        np.bincount(cell[mask], minlength=faces.cells) for mask in (size > 0, size == 3, size == 4)
    )
    first = np.concatenate([[0], np.cumsum(count)])
    rest, found = np.ones(faces.cells, dtype=bool), {}
    for kind, (n3, n4, base, beyond) in KINDS.items():
        ids = np.flatnonzero((count == n3 + n4) & (triangles == n3) & (quads == n4))
        if not len(ids):
            continue
        mine = first[ids][:, None] + np.arange(n3 + n4)
        order = np.argsort(size[mine] != base, axis=1, kind="stable")
        mine = np.take_along_axis(mine, order, axis=1)
        nodes, good = _rebuilt(_outward(faces, face[mine], sign[mine]), base, beyond)
        if good.any():
            found[kind] = nodes[good], ids[good]
            rest[ids[good]] = False
    return found, rest


def _outward(faces: Faces, face: Indices, sign: Indices) -> Indices:
    """(cells, faces, 4) nodes with the normal out of the cell; triangles are padded with -1."""
    begin, size = faces.offsets[face], np.diff(faces.offsets)[face]
    step = np.arange(4)
    place = np.where(sign[..., None] > 0, step, size[..., None] - 1 - step)
    inside = step < size[..., None]
    return np.where(inside, faces.nodes[begin[..., None] + np.where(inside, place, 0)], -1)


def _rebuilt(loops: Indices, base: int, beyond: int) -> tuple[Indices, np.ndarray]:
    """Nodes in VTK's order from outward faces, the base first; and where that worked."""
    bottom = loops[:, 0, :base][:, ::-1]  # its normal now points into the cell
    others = loops[:, 1:]
    triangle = others[..., 3:] < 0
    ahead = np.concatenate([others[..., 1:], others[..., :1]], axis=-1)
    ahead = np.where(triangle & (np.arange(4) == 2), others[..., :1], ahead)
    behind = np.concatenate([others[..., 3:], others[..., :3]], axis=-1)
    behind = np.where(triangle & (np.arange(4) == 0), others[..., 2:3], behind)
    flat = [a.reshape(len(loops), -1) for a in (others, ahead, behind)]
    top, good = np.empty_like(bottom), np.ones(len(loops), dtype=bool)
    for i in range(base):
        hit = flat[0] == bottom[:, i : i + 1]
        good &= hit.sum(axis=1) == 2
        # two faces: neighbours are the third one twice and both neighbours in the base
        around = np.where(hit, flat[1] + flat[2], 0).sum(axis=1)
        top[:, i] = (around - bottom[:, i - 1] - bottom[:, (i + 1) % base]) // 2
    nodes = np.concatenate([bottom, top[:, :1] if beyond == 1 else top], axis=1)
    ordered = np.sort(nodes, axis=1)
    good &= (ordered[:, 1:] != ordered[:, :-1]).all(axis=1)
    return nodes, good & _closed(nodes, loops)


def _closed(nodes: Indices, loops: Indices) -> np.ndarray:
    """Whether every node of every face is one of the cell's nodes."""
    known = (loops[..., None] == nodes[:, None, None, :]).any(axis=-1)
    result: np.ndarray = (known | (loops < 0)).all(axis=(1, 2))
    return result


def trihedra(faces: Faces, chosen: np.ndarray) -> tuple[Indices, Indices]:
    """Corners of the chosen cells where three faces meet: (k, 4) node and neighbours, cells."""
    cell, face, sign = sides(faces)
    mine = chosen[cell]
    cell, face, sign = cell[mine], face[mine], sign[mine]
    size = np.diff(faces.offsets)[face]
    step, count, begin = ramps(size), np.repeat(size, size), np.repeat(faces.offsets[face], size)
    here, ahead, behind = (faces.nodes[begin + (step + k) % count] for k in (0, 1, -1))
    out = np.repeat(sign > 0, size)
    ahead, behind = np.where(out, ahead, behind), np.where(out, behind, ahead)
    pairs = np.column_stack([np.repeat(cell, size), here])
    _, first, which, times = np.unique(
        pairs, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    around = np.bincount(which.ravel(), ahead).astype(np.int64)  # each neighbour once
    one = first[times == 3]
    third = around[times == 3] - ahead[one] - behind[one]
    return np.column_stack([here[one], behind[one], ahead[one], third]), pairs[one, 0]
