"""Studies of a document: what is to be optimized, and iterates shown in the lattice."""
