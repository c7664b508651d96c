"""What an expensive objective is, as a text: evaluations of another one are not its own.

Its settings, and the SHA-256 of the files that it consists of. How long it may take and how
many run at the same time changes no value and is left out.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ffdstudio.files import read_bytes

IDLE = ("processes", "time_limit")


def identity(settings: Mapping[str, Any], files: Iterable[Path]) -> str:
    """Text of the settings and of what is in the files.

    Examples
    --------
    >>> identity({"kind": "function", "processes": 2}, [])
    '[{"kind": "function"}, []]'
    """
    kept = {key: value for key, value in settings.items() if key not in IDLE}
    digests = [hashlib.sha256(read_bytes(path)).hexdigest() for path in files]
    return json.dumps([kept, digests], sort_keys=True, default=str)


def program_files(command: Iterable[str]) -> list[Path]:
    """Files among the words of a command; its first word may be found on the PATH."""
    words = [shutil.which(word) or word if k == 0 else word for k, word in enumerate(command)]
    return [path for word in words if (path := Path(word)).is_file()]


def module_files(name: str) -> list[Path]:
    """Source of the module of "module:function", if it has one."""
    try:
        found = importlib.util.find_spec(name.partition(":")[0])
    except (ImportError, ValueError):
        return []
    origin = None if found is None else found.origin
    return [Path(origin)] if origin and Path(origin).is_file() else []
