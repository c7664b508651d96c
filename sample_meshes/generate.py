"""Make every file of this folder: ``make samples``, or ``python sample_meshes/generate.py``.

1. Gmsh (from PyPI) fills areas and volumes with cells and does nothing else: every node on a
   wall comes from the section's formula here, so that it lies on it to the last bit.
2. Files that touch share nodes: the skin is made first, the structure takes its nodes from
   the skin's array, and Gmsh keeps the nodes of a discrete surface as they are.
3. The same versions of Gmsh and NumPy give the same files: one thread, a fixed seed.
"""

from pathlib import Path

import airfoil
import wing

FOLDER = Path(__file__).parent

if __name__ == "__main__":
    airfoil.write_coordinates(FOLDER / "naca0012.dat")
    airfoil.write_mesh(FOLDER / "naca0012.su2")
    wing.write_all(FOLDER)
