"""Adaptive lattices against static ones, by a protocol that is fixed beforehand."""
