"""Sections and surfaces that are optimized, and distances to targets."""
