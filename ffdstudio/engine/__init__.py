"""The FFD engine: lattices, embedding, deformation, exact refinement."""

from ffdstudio.engine.embedding import Embedding, embed
from ffdstudio.engine.lattice import Lattice

__all__ = ["Embedding", "Lattice", "embed"]
