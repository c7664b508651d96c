"""From values to colours: a map for what is bad, and one for what has changed.

Good cells stay near the ground of the picture, so that lattice, marks and labels are seen on
them; no map has the red of inverted cells.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from ffdstudio.aliases import Array
from ffdstudio.gui.theme import Theme
from ffdstudio.meshes.measures import MEASURES
from ffdstudio.project.checks.checking import Digest
from ffdstudio.project.view.scales import Scale

Colours = NDArray[np.uint8]


@functools.cache
def table(name: str, reverse: bool) -> Colours:
    """(256, 3) colours of a map."""
    import pyqtgraph

    found = pyqtgraph.colormap.get(name).getLookupTable(0.0, 1.0, 256, alpha=False)
    colours = np.asarray(found, dtype=np.uint8)
    return colours[::-1] if reverse else colours


def map_of(measure: str, change: bool, theme: Theme) -> Colours:
    """Colours along the scale: far from the theme's ground is bad; for changes red is worse."""
    worst = MEASURES[measure].worst
    if change or worst == "both":
        return table("CET-D1", worst == "low")
    return table("viridis" if theme.name == "dark" else "CET-L12", worst == "low")


def scale_of(digest: Digest, change: bool) -> Scale:
    """Scale of the colours: of ratios and changes it has its middle where nothing has changed."""
    if change:
        return Scale.around(digest.change)
    if MEASURES[digest.measure].worst == "both":
        return Scale.around(digest.change + 1.0, 1.0)
    return digest.scale


def colours_of(values: Array, scale: Scale, colours: Colours, theme: Theme) -> Colours:
    """(n, 3) colours of values; those that are no numbers get the colour of the mesh."""
    place = scale.place(values)
    none = np.isnan(place)
    rows = np.round(np.where(none, 0.0, place) * (len(colours) - 1)).astype(np.int64)
    found = colours[rows]
    found[none] = np.round(np.array(theme.rgb("mesh")) * 255).astype(np.uint8)
    return found
