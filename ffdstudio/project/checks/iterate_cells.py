"""Inverted cells of an iterate that is shown but not yet an edit: work for a worker."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ffdstudio.meshes.measures.cell_coverage import Coverage, together
from ffdstudio.project.running import Progress, no_progress
from ffdstudio.project.view.volume import countable
from ffdstudio.project.walls import after_walls

if TYPE_CHECKING:
    from ffdstudio.engine import Lattice
    from ffdstudio.project.document import Document
    from ffdstudio.project.followers import Follower
    from ffdstudio.project.model import Body, LatticeItem, Model


def checkable(document: Document) -> list[Body]:
    """Bodies whose cells can be inverted."""
    return [body for body in document.model.bodies if countable(body.mesh)]


def coverage_of(document: Document) -> Coverage:
    """Cells of all bodies that are checked, and that are not, as far as is known."""
    volumes = [document.volume(body.key) for body in document.model.bodies]
    return together(volume.coverage for volume in volumes if volume is not None)


def count_inverted(
    bodies: list[tuple[Body, Follower]],
    before: Model,
    item: LatticeItem,
    current: Lattice,
    rest: Lattice,
    progress: Progress = no_progress,
) -> int | None:
    """Count the cells that a state of a lattice inverts; None if that cannot be said.

    `rest` is the lattice at rest in the space of that state; both may be refinements.

    The embeddings of the document are asked, and nothing is added to them for the iterate:
    scrubbing would throw out those of the lattice as it is.
    """
    from ffdstudio.meshes import inverted

    steps, total = before.steps, 0
    if item not in steps or any(later.deformed for later in steps[steps.index(item) + 1 :]):
        return None
    for body, nodes in bodies:
        embedding = nodes.bound(steps, item.key, progress)[0]
        finer = embedding if rest is item.rest else embedding.refined(rest)
        points, _ = after_walls(body, finer.deform(current), None, progress)
        total += int(inverted(body.mesh, points).count)
    return total
