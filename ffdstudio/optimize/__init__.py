"""Objectives, variables, methods, adaptive refinement and recorded studies; no window needed."""

from ffdstudio.optimize.fits.fitting import fit
from ffdstudio.optimize.fits.result import FitResult

__all__ = ["FitResult", "fit"]
