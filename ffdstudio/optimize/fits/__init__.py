"""Fits: one shape brought to another."""
