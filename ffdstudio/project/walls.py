"""Bodies whose volume follows their walls: where their nodes are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ffdstudio.aliases import Array
from ffdstudio.meshes.ways import Way
from ffdstudio.project.followers import deformed
from ffdstudio.project.model import Body, LatticeItem
from ffdstudio.project.running import Progress, no_progress

if TYPE_CHECKING:
    from ffdstudio.meshes.following import Follower


def deformed_body(
    body: Body, lattices: Sequence[LatticeItem], progress: Progress = no_progress
) -> Array:
    """(n, 3) nodes of a body as the lattices deform it, in its own way; the same bits at rest.

    Raises
    ------
    InputError
        If the volume cannot follow.
    """
    if body.follows != Way.WALLS:
        return deformed(body.mesh.points, lattices, progress)
    from ffdstudio.meshes.following import carry_walls

    return carry_walls(
        body.mesh, lambda points: deformed(points, lattices, progress), told=progress
    ).points


def after_walls(
    body: Body, carried: Array, known: Follower | None, progress: Progress = no_progress
) -> tuple[Array, Follower | None]:
    """(n, 3) nodes of a body, given where the lattices carry them; and what they followed by.

    `known` is what they followed by before: it is taken again where it fits.
    """
    if body.follows != Way.WALLS:
        return carried, None
    from ffdstudio.meshes.following import follow_walls

    found = follow_walls(body.mesh, carried, told=progress, known=known)
    return found.points, found.follower
