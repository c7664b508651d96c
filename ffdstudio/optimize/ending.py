"""How a method, a level or a study ended, as a value with a message."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum


class Reason(StrEnum):
    """Why something ended; the words are those of logs and messages."""

    CONVERGED = "converged"
    STALLED = "stalled"
    TOLERANCE = "tolerance reached"
    EVALUATIONS = "evaluations spent"
    ITERATIONS = "iterations spent"
    STOPPED = "stopped"
    FAILED = "failed"
    DUE = "refinement due"
    UNKNOWN = "unknown"


ON_A_LEVEL = {Reason.CONVERGED, Reason.STALLED, Reason.DUE}
WELL = {Reason.CONVERGED, Reason.STALLED, Reason.TOLERANCE}


@dataclass(frozen=True)
class Ending:
    """How something ended.

    Attributes
    ----------
    reason : Reason
    detail : str
        What there is to say beside the reason; of a failure, what failed.
    missed : bool
        Whether constraints are not met.
    growth : str
        What ended the growth of the lattice before its number of variables.

    Examples
    --------
    >>> str(Ending(Reason.FAILED, "no licence", missed=True))
    'failed: no licence; constraints not met'
    """

    reason: Reason
    detail: str = ""
    missed: bool = False
    growth: str = ""

    def __str__(self) -> str:
        first = f"{self.reason}: {self.detail}" if self.detail else str(self.reason)
        rest = ["constraints not met"] * self.missed + [self.growth] * bool(self.growth)
        return "; ".join([first, *rest])

    @property
    def on_a_level(self) -> bool:
        """Whether more can be had from another level only."""
        return self.reason in ON_A_LEVEL

    @property
    def well(self) -> bool:
        """Whether there was nothing more to gain."""
        return self.reason in WELL

    @property
    def failed(self) -> bool:
        """Whether an evaluation failed."""
        return self.reason is Reason.FAILED

    def but(self, reason: Reason) -> Ending:
        """The same for another reason."""
        return replace(self, reason=reason)


CONVERGED, STALLED = Ending(Reason.CONVERGED), Ending(Reason.STALLED)
STOPPED, DUE = Ending(Reason.STOPPED), Ending(Reason.DUE)
