"""What a study of the document is to do, as plain values, and what it needs beforehand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.project.commands import CreateBox
from ffdstudio.project.followers import deformed
from ffdstudio.project.model import Body, LatticeItem, Model
from ffdstudio.project.studies.airfoils import Profile, profiles

if TYPE_CHECKING:
    from ffdstudio.optimize.budget import Budget

PLANE = ("contour", "pressure", "lift")
OBJECTIVES = (*PLANE, "surface", "program")
QUANTITIES = ("area", "thickness", "max thickness", "nose radius", "lift", "moment", "volume")
RELATIONS = ("at least", "at most", "equal to")
NEW = ""  # the lattice of a plan that makes its own
MARGIN = 0.01  # of the length: how far a new lattice reaches beyond nose and trailing edge
ACROSS = 0.05  # of the height: how far at least above and below


@dataclass(frozen=True)
class Limit:
    """A constraint on the shape.

    Attributes
    ----------
    quantity : str
        One of `QUANTITIES`; in chords where the shape is a section.
    relation : str
        One of `RELATIONS`.
    value : float
    place : float
        Abscissa of a thickness; angle of attack of lift and moment.
    """

    quantity: str
    relation: str = "at least"
    value: float = 0.0
    place: float = 0.0


@dataclass(frozen=True)
class Plan:
    """What is optimized, by what, how far.

    Attributes
    ----------
    body, marker : str
        Key of the body; the part of it that the objective sees, empty for all.
    lattice : str
        Key of the lattice to work on; `NEW` makes one around the shape.
    objective : str
        One of `OBJECTIVES`.
    target : str
        File, or name of a NACA four-digit section; the command line of a program.
    angle, lift : float
        Of attack, in degrees, and the lift coefficient to reach there.
    limits : tuple of Limit
    directions : str
        Letters of the coordinates in which control points move.
    frozen : int
        Outermost layers that stay.
    mirrored : int or None
        Direction of the lattice whose two ends move as mirror images.
    method, metric : str
    carry : bool
        Whether the quasi-Newton memory outlives a refinement.
    indicator : str
        Of the refinement; empty for none.
    columns, rows : int
        Of a new lattice.
    room : float
        Of the length: how far a new lattice reaches above and below the section, at least.
    axes : tuple of int
        Directions to refine.
    variables, insertions : int
        Variables at the end, knots a cycle.
    row_wise : bool
    every : int or None
        Iterations between refinements; None leaves it to the method.
    evaluations, iterations : int or None
    tolerance : float or None
        Cost at which the study has ended.
    sensitivity : bool
        Whether the program writes the derivatives too.
    time_limit : float
        Of one run of the program, in seconds.
    """

    body: str
    marker: str = ""
    lattice: str = NEW
    objective: str = "contour"
    target: str = ""
    angle: float = 2.0
    lift: float = 0.5
    limits: tuple[Limit, ...] = ()
    directions: str = "y"
    frozen: int = 0
    mirrored: int | None = None
    method: str = "gauss-newton"
    metric: str = "l2"
    carry: bool = True
    indicator: str = "gain"
    columns: int = 5
    rows: int = 2
    axes: tuple[int, ...] = (0,)
    variables: int = 70
    insertions: int = 1
    row_wise: bool = False
    every: int | None = None
    evaluations: int | None = None
    iterations: int | None = None
    tolerance: float | None = None
    sensitivity: bool = False
    time_limit: float = 600.0
    room: float = 0.0

    @property
    def plane(self) -> bool:
        """Whether the objective is about a section."""
        return self.objective in PLANE

    @property
    def budget(self) -> Budget:
        """Limits of the study."""
        from ffdstudio.optimize.budget import Budget

        return Budget(self.evaluations, self.iterations, self.tolerance)


def profile_of(body: Body, marker: str) -> Profile:
    """Section of a body by its marker; `InputError` if it is none."""
    for profile in profiles(body.mesh):
        if profile.marker == marker:
            if not np.array_equal(profile.axes, np.eye(3)[:2]):
                raise InputError(
                    f"the section of {body.name} does not lie along x and y, as studies need it to"
                )
            return profile
    part = f"the marker {marker} of {body.name}" if marker else body.name
    raise InputError(f"{part} is no airfoil section")


def checked(plan: Plan, model: Model) -> Plan:
    """Return the plan if it can begin.

    Raises
    ------
    InputError
        If something is missing, or the lattice is not the last one that deforms the body.
    """
    body = model.body(plan.body)
    if plan.objective != "lift" and not plan.target.strip():
        what = "a command" if plan.objective == "program" else "a target"
        raise InputError(f"the objective needs {what}")
    flat = plan.objective == "program" and body.mesh.dimension == 2
    if plan.plane or flat:
        profile_of(body, plan.marker)
    elif plan.lattice == NEW:
        raise InputError("build a lattice around the surface first")
    if not plan.directions:
        raise InputError("control points need a direction to move in")
    if plan.lattice != NEW:
        item = model.lattice(plan.lattice)
        later = model.steps[model.steps.index(item) + 1 :] if item in model.steps else None
        if later is None:
            raise InputError(f"{item.name} is switched off")
        if any(other.deformed for other in later):
            raise InputError(f"{later[-1].name} deforms what {item.name} leaves; switch it off")
    return replace(plan, target=plan.target.strip())


def start_points(model: Model, body: Body, item: LatticeItem | None) -> Array:
    """(n, 3) nodes of a body as the lattices before one leave them."""
    steps = model.steps
    if item is not None:
        steps = steps[: [other.key for other in steps].index(item.key)]
    return deformed(body.mesh.points, steps)


def box_around(plan: Plan, model: Model) -> CreateBox:
    """Lattice around a section: cubic along it, of the highest degree across.

    Columns at the Greville abscissae, so that refinements keep them there.
    """
    body = model.body(plan.body)
    points = start_points(model, body, None)[profile_of(body, plan.marker).nodes]
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    length, height = (high - low).tolist()
    reach = np.array([MARGIN * length, max(ACROSS * height, plan.room * length)])
    lower, upper = (tuple(map(float, (*v, 0.0))) for v in (low - reach, high + reach))
    return CreateBox(
        "Study lattice", lower, upper, (plan.columns, plan.rows), (3, plan.rows - 1),
        frozen=plan.frozen,
    )  # fmt: skip
