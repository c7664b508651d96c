"""Meshes: the container, one file per format, quality and safety."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ffdstudio.meshes.mesh import Faces, Mesh, MeshWarning
from ffdstudio.meshes.reading import read_mesh
from ffdstudio.meshes.writing import losses, write_mesh

if TYPE_CHECKING:
    from ffdstudio.meshes.following import Follower
    from ffdstudio.meshes.measures import Coverage, coverage, inverted, quality
    from ffdstudio.meshes.safety import safe_amplitude

_LATER = {
    "Coverage": "measures",
    "Follower": "following",
    "coverage": "measures",
    "inverted": "measures",
    "quality": "measures",
    "safe_amplitude": "safety",
}
__all__ = [
    "Coverage",
    "Faces",
    "Follower",
    "Mesh",
    "MeshWarning",
    "coverage",
    "inverted",
    "losses",
    "quality",
    "read_mesh",
    "safe_amplitude",
    "write_mesh",
]


def __getattr__(name: str) -> Any:
    """Load what reading a mesh does not need on first use."""
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_LATER[name]}"), name)
    globals()[name] = value
    return value
