"""Messages between a process and the one that it asks: JSON, then arrays as ``.npy``.

Eight bytes of length come before each part, and sixteen of a mark before the whole.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ffdstudio.aliases import AnyArray
from ffdstudio.containers import npy, strictjson

MARK = b"ffdstudio-meshes"


def packed(head: Mapping[str, Any], arrays: Sequence[AnyArray] = ()) -> bytes:
    """Return a message.

    Examples
    --------
    >>> message = packed({"points": 0}, [np.arange(3)])
    >>> unpacked(message)
    ({'points': 0}, [array([0, 1, 2])])
    """
    parts = [json.dumps(dict(head)).encode(), *map(_saved, arrays)]
    framed = [len(part).to_bytes(8, "big") + part for part in parts]
    return b"".join([MARK, len(parts).to_bytes(8, "big"), *framed])


def unpacked(message: bytes) -> tuple[dict[str, Any], list[AnyArray]]:
    """Return what a message says; the one who sends it may have been led astray by its file.

    Raises
    ------
    ValueError
        If it is no whole message.
    """
    if not message.startswith(MARK):
        raise ValueError("no message")
    take = _taker(message, len(MARK))
    count = int.from_bytes(take(8), "big")
    parts = [take(int.from_bytes(take(8), "big")) for _ in range(min(count, 1_000_000))]
    if not parts:
        raise ValueError("an empty message")
    return strictjson.loads(parts[0], "the message"), [npy.loads(part) for part in parts[1:]]


def _taker(message: bytes, at: int) -> Callable[[int], bytes]:
    def take(count: int) -> bytes:
        nonlocal at
        if at + count > len(message):
            raise ValueError("the message ends too early")
        at += count
        return message[at - count : at]

    return take


def _saved(array: AnyArray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.ascontiguousarray(array), allow_pickle=False)
    return stream.getvalue()
