"""Failures of an evaluation that a method can step back from."""

from __future__ import annotations

from ffdstudio.optimize.objectives.remembered import EvaluationError


class NotFinite(EvaluationError):
    """The cost of a shape is no finite number: a line search takes a shorter step."""
