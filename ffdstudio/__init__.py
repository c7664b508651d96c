"""FFD Studio: free-form deformation of geometry and CFD meshes.

``import ffdstudio as ffd`` is light: names are loaded from their rooms on first use, so
neither Qt nor VTK nor a numba compilation is paid for by a script that needs none.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ffdstudio.engine import Embedding, Lattice, embed
    from ffdstudio.errors import InputError
    from ffdstudio.exchange import read_lattice, write_lattice
    from ffdstudio.meshes import Follower, Mesh, quality, read_mesh, write_mesh
    from ffdstudio.optimize import fit
    from ffdstudio.project import Project

from ffdstudio.version import __version__

_ROOM_OF = {
    "Embedding": "engine",
    "Follower": "meshes",
    "InputError": "errors",
    "Lattice": "engine",
    "Mesh": "meshes",
    "Project": "project",
    "embed": "engine",
    "fit": "optimize",
    "quality": "meshes",
    "read_lattice": "exchange",
    "read_mesh": "meshes",
    "write_lattice": "exchange",
    "write_mesh": "meshes",
}
__all__ = [
    "Embedding",
    "Follower",
    "InputError",
    "Lattice",
    "Mesh",
    "Project",
    "__version__",
    "embed",
    "fit",
    "quality",
    "read_lattice",
    "read_mesh",
    "write_lattice",
    "write_mesh",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOM_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_ROOM_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
