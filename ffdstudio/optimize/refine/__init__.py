"""Adaptive refinement: where a lattice gains most from a new knot."""
