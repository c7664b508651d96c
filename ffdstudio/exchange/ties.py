"""Which lattices of a file touch one another, and would have to move together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ffdstudio.aliases import Array

CLOSE = 1e-4  # the distance within which pyGeo ties control points


def untied(nets: Sequence[Array], names: Sequence[str], index: int, what: str) -> tuple[str, ...]:
    """Say with which other lattices one shares control points.

    Parameters
    ----------
    nets : sequence of numpy.ndarray
        (..., 3) control points of all lattices of a file.
    names : sequence of str
    index : int
        Of the one that is taken.
    what : str
        What the file calls a lattice.

    Examples
    --------
    >>> square = np.stack(np.meshgrid([0.0, 1], [0.0, 1], [0.0], indexing="ij"), axis=-1)
    >>> untied([square, square + [1, 0, 0]], ["0", "1"], 0, "block")[0][:45]
    'block 0 shares 2 control points with block 1;'
    """
    from scipy.spatial import cKDTree

    tree, found = cKDTree(nets[index].reshape(-1, 3)), []
    for k, net in enumerate(nets):
        far, _ = tree.query(net.reshape(-1, 3), distance_upper_bound=CLOSE)
        near = int(np.count_nonzero(np.asarray(far) <= CLOSE))
        if k != index and near:
            found.append(f"{near} control points with {what} {names[k]}")
    if not found:
        return ()
    return (
        f"{what} {names[index]} shares {', '.join(found)}; they are not tied here: moved alone it "
        "tears the mesh there, and moved alike both move what lies on their common face",
    )
