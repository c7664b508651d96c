"""Failures of an evaluation."""

from __future__ import annotations

from ffdstudio.errors import InputError


class EvaluationError(InputError):
    """An evaluation failed; the study ends there and can be resumed."""


class NotFinite(EvaluationError):
    """The cost of a shape is no finite number: a line search takes a shorter step."""
