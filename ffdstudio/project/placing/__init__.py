"""Where a lattice goes: around the shape, with room to move it, seated on planes."""
