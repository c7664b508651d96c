"""Meshes that follow a study's lattice: kept valid, and felt by the metric of its variables."""
