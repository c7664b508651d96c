"""NumPy's ``.npy`` of plain numbers, read without believing its header.

NumPy's own reader evaluates the header as Python, which a stranger's file can make fail in a
dozen ways. What `numpy.save` writes for numbers is one line of one form: only that is read.
"""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

_MAGIC = b"\x93NUMPY\x01\x00"
_HEADER = re.compile(
    rb"\{'descr': '([<>|][biuf]\d{1,2}|<U\d{1,9})', 'fortran_order': (True|False), "
    rb"'shape': \(((?:\d{1,18}, )*(?:\d{1,18},?)?)\), \} *\n"
)


def loads(data: bytes, text: bool = False) -> NDArray[Any]:
    """Return the array in the content of a ``.npy`` file.

    Parameters
    ----------
    data : bytes
    text : bool
        Whether it may hold texts instead of numbers.

    Raises
    ------
    ValueError
        If it is not what `numpy.save` makes of an array of numbers, or its data is not of
        the size that the header announces.

    Examples
    --------
    >>> import io
    >>> stream = io.BytesIO()
    >>> np.save(stream, np.arange(3.0))
    >>> loads(stream.getvalue())
    array([0., 1., 2.])
    """
    begin = 10 + int.from_bytes(data[8:10], "little")
    match = _HEADER.fullmatch(data[10:begin])
    if not data.startswith(_MAGIC) or match is None:
        raise ValueError("not the header of an array of numbers")
    if match[1].startswith(b"<U") and not text:
        raise ValueError("texts, no numbers")
    try:
        dtype = np.dtype(match[1].decode())
    except TypeError as error:
        raise ValueError("no type of numbers") from error
    shape = tuple(int(length) for length in match[3].replace(b",", b" ").split())
    if len(shape) > 32 or math.prod(shape) * dtype.itemsize != len(data) - begin:
        raise ValueError("the header announces another size")
    flat = np.frombuffer(data, dtype, offset=begin)
    if match[2] == b"True":
        return np.asfortranarray(flat.reshape(shape[::-1]).T.copy("F"))
    return flat.reshape(shape).copy()
