"""Metrics in which design variables are orthonormal: one file for each."""
