"""What every objective says of itself before it is made."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Self

from ffdstudio.optimize.geometry.sections import is_naca
from ffdstudio.optimize.spec.rows import Row

if TYPE_CHECKING:
    from ffdstudio.optimize.build.place import Place
    from ffdstudio.optimize.geometry.contour import Contour
    from ffdstudio.optimize.geometry.shapes import Shape
    from ffdstudio.optimize.objectives.base import Objective
    from ffdstudio.optimize.objectives.distance import Distance


class ObjectiveSpec(Row, frozen=True, kw_only=True):
    """Base of all objectives.

    Attributes
    ----------
    residuals : bool
        Whether the cost is half a sum of squares whose parts come too.
    whole : bool
        Whether it sees all nodes of a mesh, not the marker's alone.
    by_points : bool
        Whether it is a mean over points, not over the length of the section.
    runs_code : bool
        Whether it runs somebody else's code: never unasked.
    """

    table: ClassVar[str] = "objective"
    residuals: ClassVar[bool] = False
    whole: ClassVar[bool] = False
    by_points: ClassVar[bool] = False
    runs_code: ClassVar[bool] = False

    @property
    def aim(self) -> str:
        """Name of the section that is to be reached, for views; empty if there is none."""
        return ""

    @property
    def attack(self) -> float | None:
        """Angle of attack that a view of the flow begins with; None without a flow."""
        return None

    def moved(self, change: Callable[[str], str]) -> Self:
        """The same objective with other names for its files: its case lies in another folder.

        Names of sections and paths from the root stay as they are.
        """
        return self

    def contour(self, place: Place) -> Contour | None:
        """Section that the shape, or its flow, is to become."""
        return None

    def require(self, place: Place) -> None:
        """Refuse to run somebody else's code that came inside a file and is not agreed to.

        Raises
        ------
        NotTrusted
            See `consent`.
        """

    def build(self, shape: Shape, place: Place) -> Objective:
        """The objective of a shape, of a section in chords.

        Raises
        ------
        InputError
            If what it names cannot be read, or does not fit the shape.
        """
        raise NotImplementedError

    def judged(self, objective: Objective, place: Place) -> Contour | Distance | None:
        """What errors are measured against, if there is a shape to reach."""
        return self.contour(place)

    def files(self, shape: Shape, place: Place) -> list[Path] | None:
        """Files that an expensive objective consists of; None if it need not be remembered."""
        return None


def moved_file(name: str, change: Callable[[str], str]) -> str:
    """A changed name of a file; names of sections, of objects at hand and absolute paths stay."""
    fixed = not name or is_naca(name) or name.startswith("<") or Path(name).is_absolute()
    return name if fixed else change(name)
