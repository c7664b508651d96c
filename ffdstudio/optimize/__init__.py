"""Objectives, variables, methods, adaptive refinement and recorded studies; no window needed."""

from ffdstudio.optimize.fits.fitting import FitResult, fit

__all__ = ["FitResult", "fit"]
