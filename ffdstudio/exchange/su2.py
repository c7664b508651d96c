"""FFD boxes inside SU2 meshes, as lattices and back.

1. SU2's parameters run from 0 to 1; the cached embedding (FFD_SURFACE_POINTS) is in these.
2. A box of a 2D mesh has two layers at z = -0.5 and 0.5; it becomes a lattice of two
   directions. BEZIER has no inner knot, BSPLINE_UNIFORM equally long spans.
3. A morphed mesh needs its boxes to follow: left as they were, SU2_DEF would move the
   surface back to where it was (`follow`).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.engine import Lattice, embed
from ffdstudio.engine.knots import clamped_uniform
from ffdstudio.errors import InputError
from ffdstudio.exchange import su2text
from ffdstudio.exchange.conversion import ConversionRules, adapted
from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.exchange.su2text import Box
from ffdstudio.exchange.text import chosen, naming
from ffdstudio.exchange.ties import untied
from ffdstudio.files import read_bytes, sources_kept, write_bytes
from ffdstudio.meshes import Mesh, read_mesh

RULES = ConversionRules("SU2", dimensions=(2, 3), uniform=True, weights=False)
DEFAULT_TAG = "MAIN_BOX"
# corners of a net in VTK's order of a hexahedron
_CORNERS = ((0, 0, 0), (-1, 0, 0), (-1, -1, 0), (0, -1, 0))
_CORNERS_3D = (*_CORNERS, *((i, j, -1) for i, j, _ in _CORNERS))


def recognises(data: bytes) -> bool:
    """Whether it looks like an SU2 mesh."""
    return b"NDIME" in data[:100_000]


def tags(data: bytes, name: str) -> list[str]:
    """Tags of the boxes in a mesh, without reading the mesh."""
    return [box.tag for box in su2text.all_boxes(data, name)]


def lattices(data: bytes, name: str) -> list[tuple[str, Lattice | InputError]]:
    """Tags with the lattices of all boxes, a broken one as what is wrong with it."""
    return [(tag, _tried(box)) for tag, box in su2text.each_box(data, name)]


def _tried(box: Box | InputError) -> Lattice | InputError:
    try:
        return box if isinstance(box, InputError) else lattice_of(box)
    except InputError as error:
        return error


def read(data: bytes, name: str, block: int | str | None = None) -> LatticeFile:
    """Read one box of a mesh, by tag or index."""
    boxes = su2text.all_boxes(data, name)
    if not boxes:
        raise InputError(f"{name}: this mesh has no FFD box")
    names = tuple(box.tag for box in boxes)
    box = boxes[chosen(names, block, name, "FFD box")]
    with naming(f"{name}: FFD box {box.tag}"):
        lattice = lattice_of(box)
    nets = [_spanned(each) if each.net is None else each.net for each in boxes]
    return LatticeFile(
        lattice, lattice, exactness=_note(box), format="su2", blocks=names,
        notes=(*nested(box), *untied(nets, names, names.index(box.tag), "FFD box")),
    )  # fmt: skip


def nested(box: Box) -> tuple[str, ...]:
    """Say which boxes ride on one another in SU2, and do not here."""
    told = []
    if box.parents:
        told.append(
            f"FFD box {box.tag} rides on its parent {', '.join(box.parents)} in SU2; here it stays "
            "where it is when that one moves"
        )
    if box.children:
        told.append(
            f"FFD box {box.tag} carries {', '.join(box.children)} in SU2; here they stay where "
            "they are when it moves"
        )
    return tuple(told)


def lattice_of(box: Box) -> Lattice:
    """Return the lattice of a box; one that is not set up yet is spanned by its corners."""
    net = _spanned(box) if box.net is None else box.net
    if len(box.counts) == 2:
        net = _flat(net)
    orders = box.orders or box.counts
    degrees = [min(order, n) - 1 for order, n in zip(orders, box.counts, strict=True)]
    knots = [clamped_uniform(n, p) for n, p in zip(box.counts, degrees, strict=True)]
    return Lattice(degrees, knots, net)


def write(
    path: Path,
    content: LatticeFile,
    adapt: str = "refuse",
    tag: str = DEFAULT_TAG,
    markers: Sequence[str] | None = None,
) -> Exactness:
    """Put the lattice into an existing SU2 mesh as a box, replacing the one of that tag.

    The nodes of `markers`, by default of all, that lie in the lattice are embedded for SU2.
    """
    if isinstance(markers, str) or not isinstance(markers, Sequence | None):
        raise InputError(f"the markers must be a list of names, got {markers!r}")
    fitting, exactness = adapted(content, RULES, adapt)
    data = read_bytes(path, to_update=True)
    with sources_kept():  # the mesh that gets the box is no source of what is written
        mesh = read_mesh(path)
    new = with_box(data, mesh, fitting.current, tag, markers, str(path))
    write_bytes(path, new)
    return exactness


def with_box(
    data: bytes,
    mesh: Mesh,
    lattice: Lattice,
    tag: str,
    markers: Sequence[str] | None = None,
    name: str = "the mesh",
) -> bytes:
    """Return the mesh file with a box added, or the one of that tag replaced."""
    if su2text.has_zones(data):
        raise InputError(
            f"{name}: a box cannot be put into a mesh of several zones, each with its own numbers"
        )
    section = su2text.parse(data, name)
    if lattice.dimension != section.dimension:
        raise InputError(
            f"{name}: a box in a {section.dimension}D mesh needs a lattice of {section.dimension} "
            f"directions, not {lattice.dimension}"
        )
    if not isinstance(tag, str) or tag.split() != [tag] or "%" in tag or "=" in tag:
        raise InputError(f"{tag!r} is no tag for an FFD box: it must be one word")
    old = {box.tag: box for box in section.boxes}
    box = new_box(lattice, tag, old.get(tag))
    box.surface = _embedded(lattice, mesh, mesh.points, markers)
    old[tag] = box
    section.boxes = list(old.values())
    return su2text.replaced(data, section)


def follow(
    data: bytes, mesh: Mesh, points: Array, motions: Sequence[tuple[Lattice, Lattice]]
) -> bytes:
    """Return boxes that follow a morphed shape, as SU2_DEF leaves them.

    A box that is the lattice itself gets its control points and keeps its embedding; any
    other one is moved as if it were part of the mesh, and the surface embedded anew.

    Parameters
    ----------
    data : bytes
        The boxes, or a whole file with them.
    mesh : Mesh
        The mesh before.
    points : numpy.ndarray
        (n, 3) its nodes after.
    motions : sequence of (Lattice, Lattice)
        What moved them, in order: lattices at rest and deformed.
    """
    motions = [(rest, current) for rest, current in motions if rest != current]
    if not motions:  # then it need not even be readable
        return data
    section = su2text.parse(data, "the mesh", mesh.dimension)
    if not section.boxes:
        return data
    rest, current = motions[0]
    for number, box in enumerate(section.boxes):
        old = lattice_of(box)
        ours = len(motions) == 1 and _same_map(old, rest) and (current.weights == 1).all()
        if ours:
            new = new_box(current, box.tag, box)
            new.surface = box.surface
        else:
            new = _carried_along(box, old, mesh, points, motions)
        section.boxes[number] = new
    return su2text.replaced(data, section)


def _same_map(box: Lattice, lattice: Lattice) -> bool:
    """Whether a lattice is the one of a box, but for the range of its parameters."""
    if box.degrees != lattice.degrees or not np.array_equal(
        box.control_points, lattice.control_points
    ):
        return False
    pairs = zip(box.knots, lattice.knots, strict=True)
    same = all(np.allclose(u, (v - v[0]) / (v[-1] - v[0]), 0, 1e-12) for u, v in pairs)
    return same and np.array_equal(box.weights, lattice.weights)


def _carried_along(
    box: Box, old: Lattice, mesh: Mesh, points: Array, motions: Sequence[tuple[Lattice, Lattice]]
) -> Box:
    moved = _flat_net(old)
    for rest, current in motions:
        moved = embed(rest, moved).deform(current)
    lattice = old.moved(moved.reshape(old.control_points.shape))
    new = new_box(lattice, box.tag, box)
    marked = {line.split()[0].decode("utf-8", "replace") for line in box.surface}
    unknown = sorted(marked - mesh.markers.keys())  # zones have their own names and numbers
    if unknown:
        raise InputError(
            f"FFD box {box.tag} embeds nodes of {unknown[0]}, which is no marker of the whole "
            "mesh, and cannot follow: strip the boxes or keep them"
        )
    new.surface = _embedded(
        lattice, mesh, points, [name for name in mesh.markers if name in marked]
    )
    return new


def _flat_net(lattice: Lattice) -> Array:
    return lattice.control_points.reshape(-1, 3)


def new_box(lattice: Lattice, tag: str, old: Box | None = None) -> Box:
    """Return a box of this net, without embedded points, in the place of an old one."""
    bezier = all(n == p + 1 for n, p in zip(lattice.shape, lattice.degrees, strict=True))
    orders = None if bezier else tuple(p + 1 for p in lattice.degrees)
    net = lattice.control_points
    if lattice.dimension == 2:
        net = np.stack([net, net], axis=2)
        net[:, :, 0, 2], net[:, :, 1, 2] = -0.5, 0.5
    corners = _CORNERS if lattice.dimension == 2 else _CORNERS_3D
    return Box(
        tag,
        old.level if old else 0,
        lattice.shape,
        orders,
        old.parents if old else [],
        old.children if old else [],
        np.array([net[corner][: lattice.dimension] for corner in corners]),
        net,
    )


def _embedded(
    lattice: Lattice, mesh: Mesh, points: Array, markers: Sequence[str] | None
) -> list[bytes]:
    """Lines ``marker node u v w`` of the marked nodes inside the lattice."""
    lines = []
    low, high = lattice.domain.T
    for marker in mesh.markers if markers is None else markers:
        nodes = mesh.marker_nodes(marker)
        found = embed(lattice, points[nodes])
        inside = found.parameters[found.inside]
        uvw = np.full((len(inside), 3), 0.5)
        uvw[:, : lattice.dimension] = np.clip((inside - low) / (high - low), 0, 1)
        for node, row in zip(nodes[found.inside].tolist(), uvw.tolist(), strict=True):
            lines.append("\t".join([marker, str(node), *(f"{x:.16e}" for x in row)]).encode())
    return lines


def _flat(net: Array) -> Array:
    """Return the layer of a 2D box; its two layers must say the same."""
    if not np.array_equal(net[:, :, 0, :2], net[:, :, 1, :2]):
        raise InputError("the two layers of this 2D box differ")
    flat = net[:, :, 0].copy()
    flat[..., 2] = 0.0
    return flat


def _spanned(box: Box) -> Array:
    """Control points of a box that SU2 has not set up: spread evenly between its corners."""
    corners = np.zeros((2, 2, 2, 3))
    for corner, point in zip(
        _CORNERS_3D, np.resize(box.corners, (8, box.corners.shape[1])), strict=True
    ):
        corners[corner][: len(point)] = point
    if box.corners.shape[1] == 2:
        corners[:, :, 0, 2], corners[:, :, 1, 2] = -0.5, 0.5
    net = corners
    for axis, n in enumerate((*box.counts, 2)[:3]):
        t = np.linspace(0, 1, n)
        net = np.moveaxis(np.tensordot(np.stack([1 - t, t], axis=1), net, (1, axis)), 0, axis)
    return net


def _note(box: Box) -> Exactness:
    if box.net is None:
        return Exactness(True, "SU2 has not set this box up: it is spanned by its corners")
    if box.orders is not None:
        return Exactness(True, "SU2 itself evaluates a uniform B-spline as 0 at the far faces")
    nested = f"level {box.level}, parents: {', '.join(box.parents)}" if box.parents else ""
    return Exactness(True, nested)
