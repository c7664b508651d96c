"""The inverse problem: parametric coordinates of given points.

The way of a point: `affine` answers for boxes at rest in closed form. Any other net is cut
into `cells` in which its map is nearly affine; `bins` finds the few cells that can hold
a point; `kernels` solves inside a cell by one of the four methods.
"""

from ffdstudio.engine.inversion.found import Inversion
from ffdstudio.engine.inversion.solve import METHODS, invert

__all__ = ["METHODS", "Inversion", "invert"]
