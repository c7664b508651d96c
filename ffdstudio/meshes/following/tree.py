"""Sources in clusters, and which of them each box of targets sees one by one.

1. A source's field is affine, so the sum over a cluster far away is affine as well and no more
   than one weight times one affine field about the cluster's centre.
2. The trees are SciPy's; their leaves are runs of one permutation.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ffdstudio.aliases import Array, Indices


class Runs(NamedTuple):
    """Nodes of a tree, parents before children, each a run of `order`.

    Attributes
    ----------
    order : numpy.ndarray
        (n,) permutation of the points.
    begin, end : numpy.ndarray
        (nodes,) of the run.
    children : numpy.ndarray
        (nodes, 2), -1 in a leaf.
    """

    order: Indices
    begin: Indices
    end: Indices
    children: Indices

    @property
    def leaves(self) -> Indices:
        """Numbers of the leaves."""
        return np.flatnonzero(self.children[:, 0] < 0)


def runs(points: Array, size: int) -> Runs:
    """Tree over (n, 3) points whose leaves hold up to `size`, more only where points coincide.

    Examples
    --------
    >>> tree = runs(np.arange(8.0)[:, None] * [1, 0, 0], 4)
    >>> tree.begin, tree.end
    (array([0, 0, 4]), array([8, 4, 8]))
    """
    from scipy.spatial import cKDTree

    tree: Any = cKDTree(points, leafsize=size, balanced_tree=True, compact_nodes=True)
    begin: list[int] = []
    end: list[int] = []
    children: list[list[int]] = []
    waiting = [(tree.tree, -1, 0)]
    while waiting:
        node, parent, side = waiting.pop()
        number = len(begin)
        begin.append(node.start_idx)
        end.append(node.end_idx)
        children.append([-1, -1])
        if parent >= 0:
            children[parent][side] = number
        if node.split_dim >= 0:
            waiting += [(node.greater, number, 1), (node.lesser, number, 0)]
    return Runs(
        np.asarray(tree.indices, dtype=np.int64), np.array(begin), np.array(end), np.array(children)
    )
