"""Where the sample meshes lie: beside the package in a checkout, inside it once installed."""

from __future__ import annotations

from pathlib import Path

from ffdstudio.errors import InputError

HERE = Path(__file__).parent
FOLDERS = (HERE / "sample_meshes", HERE.parent / "sample_meshes")


def sample(name: str) -> Path:
    """Path of a sample mesh or airfoil.

    Raises
    ------
    InputError
        If there is none of that name; the message lists those there are.

    Examples
    --------
    >>> sample("naca0012.su2").name
    'naca0012.su2'
    """
    folder = next((path for path in FOLDERS if path.is_dir()), FOLDERS[0])
    names = sorted(
        path.name for path in folder.glob("[!.]*.*") if path.suffix not in {".py", ".md"}
    )
    if name not in names:
        raise InputError(f"there is no sample {name!r}; there are: {', '.join(names) or 'none'}")
    return folder / name
