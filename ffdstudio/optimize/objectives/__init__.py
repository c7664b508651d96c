"""Objectives: what a study makes small."""
