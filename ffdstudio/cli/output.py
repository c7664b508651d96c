"""What subcommands print: one JSON object, or lines for people; notes on stderr."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np


def emit(result: Mapping[str, Any], text: str, as_json: bool) -> None:
    """Print a result: the object with ``--json``, else the text."""
    if as_json:
        # what the stream cannot say it would write as escapes of Python, which JSON does not know
        escaped = "utf" not in (sys.stdout.encoding or "").lower()
        print(json.dumps(result, allow_nan=False, default=_plain, ensure_ascii=escaped))
    else:
        print(text)


def note(text: str) -> None:
    """Say something beside the result, on stderr."""
    print(f"ffdstudio: {text}", file=sys.stderr)


def sized(shape: tuple[int, ...]) -> str:
    """Return ``8x6x4``."""
    return "x".join(map(str, shape))


def _plain(value: object) -> object:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is nothing that JSON knows")
