"""What each measure is, after whom, and where the solvers draw the line."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Measure:
    """A measure per cell.

    Attributes
    ----------
    title, unit : str
        For people; the unit is empty for ratios, "mesh" for powers of the mesh's unit.
    standard : str
        Whose definition it is.
    worst : str
        Which end is bad: "high", "low", or "both" (away from 1).
    """

    title: str
    standard: str
    worst: str
    unit: str = ""


@dataclass(frozen=True)
class Limit:
    """A value of a measure that a solver's guide advises against."""

    preset: str
    measure: str
    relation: str  # ">" or "<"
    value: float


MEASURES = {
    "skewness": Measure("equiangle skewness", "Pointwise and Fluent: equiangle", "high"),
    "scaled_jacobian": Measure("scaled Jacobian", "Verdict", "low"),
    "aspect_ratio": Measure("aspect ratio", "OpenFOAM checkMesh", "high"),
    "volume": Measure("volume", "OpenFOAM checkMesh; area of surfaces", "low", "mesh"),
    "non_orthogonality": Measure("non-orthogonality", "OpenFOAM checkMesh", "high", "degrees"),
    "face_skewness": Measure("face skewness", "OpenFOAM checkMesh", "high"),
    "orthogonal_quality": Measure("orthogonal quality", "Fluent: orthogonal quality", "low"),
    "growth_ratio": Measure(
        "growth ratio", "larger over smaller volume of cells that share a face", "high"
    ),
    "volume_ratio": Measure("volume ratio", "volume over undeformed volume", "both"),
    "first_layer_ratio": Measure(
        "first-layer height ratio",
        "volume over wall area of cells at a wall, over its undeformed value",
        "both",
    ),
}
LIMITS = (
    Limit("Fluent", "skewness", ">", 0.9),
    Limit("Fluent", "orthogonal_quality", "<", 0.1),
    Limit("OpenFOAM", "non_orthogonality", ">", 70.0),
    Limit("OpenFOAM", "face_skewness", ">", 4.0),
    Limit("OpenFOAM", "aspect_ratio", ">", 1000.0),
    Limit("OpenFOAM", "volume", "<", 0.0),
    Limit("SU2", "volume", "<", 0.0),
)
