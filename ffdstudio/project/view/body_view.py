"""A body as the document follows it: displayed points, proxy, all nodes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ffdstudio.engine import Lattice
from ffdstudio.meshes import Mesh
from ffdstudio.project.followers import Follower
from ffdstudio.project.model import LatticeItem
from ffdstudio.project.running import Progress
from ffdstudio.project.view.surface import DisplaySurface
from ffdstudio.project.view.volume import DeformedVolume

if TYPE_CHECKING:
    from ffdstudio.meshes.following import Follower as VolumeFollower


class BodyView:
    """Surface, proxy and nodes of one mesh, each with its follower.

    Attributes
    ----------
    surface : DisplaySurface
    full, nodes : Follower
        Of the displayed points, and of all nodes of the mesh.
    proxy : Follower or None
        Of the rows that the proxy shows, if there is one.
    volume : DeformedVolume or None
        None while it is not up to date.
    expected : list of (Lattice, Lattice)
        The states of the lattices that `volume` is about, or will be.
    outdated : bool
        Whether `volume` has to be worked out and nobody does that yet, or any more.
    checking : bool
        Whether somebody does.
    """

    def __init__(self, mesh: Mesh, surface: DisplaySurface) -> None:
        self.mesh = mesh
        self.surface = surface
        everything = len(surface.nodes) == len(mesh.points)
        self.full = Follower(mesh.points if everything else mesh.points[surface.nodes])
        self.nodes = self.full if everything else Follower(mesh.points)
        self.proxy = None
        if surface.proxy is not None:
            self.proxy = Follower(self.full.points[surface.proxy.rows])
        self.volume: DeformedVolume | None = None
        self.expected: tuple[str, list[tuple[Lattice, Lattice]]] | None = None
        self.by: VolumeFollower | None = None
        self.outdated = True
        self.checking = False

    @property
    def followers(self) -> list[Follower]:
        """Those that are displayed."""
        return [self.full] if self.proxy is None else [self.full, self.proxy]

    @property
    def in_hand(self) -> Follower:
        """The one that follows a drag."""
        return self.full if self.proxy is None else self.proxy

    @property
    def settled(self) -> bool:
        """Whether all that is displayed is where it belongs."""
        return all(follower.settled for follower in self.followers)

    def settle(self, lattices: Sequence[LatticeItem]) -> None:
        """Take displayed points where the lattices want them, as far as that is known."""
        for follower in self.followers:
            follower.settle(lattices)

    def expect(self, follows: str, state: list[tuple[Lattice, Lattice]]) -> None:
        """Forget the volume if it is about other states of the lattices, or another way."""
        if self.expected != (follows, state):
            self.expected, self.volume, self.outdated = (follows, state), None, True

    def embed(self, lattices: Sequence[LatticeItem], progress: Progress) -> None:
        """Make the embeddings that are missing; for a worker."""
        for follower in self.followers:
            follower.embed(lattices, progress)
