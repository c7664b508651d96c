"""What a document reads and writes: projects, meshes, lattices, journal, recovery."""
