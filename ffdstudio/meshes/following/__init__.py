"""A volume mesh follows its surface: inverse distance weighting with rotations.

1. Each surface node carries the rigid motion of the surface about it; a volume node moves by
   their mean, weighted by area and inverse powers of the distance (Luke, Collins, Blades, J.
   Comput. Phys. 231, 2012). Beside a wall the nearest motion alone counts, so that layers keep
   their heights and angles. Only points are looked at: any kind of cell will do.
2. It was chosen by measurement. First-layer height ratios, and the worst non-orthogonality in
   degrees (99.9th percentile), no cell inverted in any; the prototypes of the others were
   written for the comparison and are not part of the product:

   ========================  =================  =================  =================
   motion                    this one           RBF, Wendland C2,  linear elasticity,
                                                greedy centres     1 / cell volume
   ========================  =================  =================  =================
   RAE 2822, skin by 0.037   1.000-1.000, 24.2  0.993-1.175, 32.4  1.000-1.005, 24.1
   RAE 2822, 10 degrees      1.000-1.000, 23.9  0.995-1.001, 23.8  1.015-1.015, 24.1
   RAE 2822, bump of 0.1     0.983-1.000, 26.4  0.978-1.876, 37.2  0.993-1.057, 25.4
   NACA 0012, bump of 0.1    1.000-1.000, 27.0  1.000-1.928, 38.0  0.999-1.057, 23.2
   M6 tets bent by a tenth   0.913-1.092, 74.4  0.908-1.100, 74.6  0.913-1.092, 74.5
   ========================  =================  =================  =================

   Elasticity comes near, but needs a sparse factorisation (some 30 times the set-up on the
   11 528 nodes of the M6, out of reach for a million), cells it can integrate over and small
   strains; RBF with greedy centres is the cheapest and lets boundary layers stretch.
3. Symmetry planes are mirrors and periodic boundaries repeat: their images are sources as well,
   so nodes beside them feel no edge. That nodes stay in planes and with partners is exact.
4. Turns of over 60 degrees are gone in steps.
5. Memory: some 100 bytes for each node, and four for each item that a box of nodes sees.
"""

from ffdstudio.meshes.following.carried import METHOD, Carried, carry_walls, follow_walls
from ffdstudio.meshes.following.follower import Follower
from ffdstudio.meshes.following.roles import moved_boundaries

__all__ = ["METHOD", "Carried", "Follower", "carry_walls", "follow_walls", "moved_boundaries"]
