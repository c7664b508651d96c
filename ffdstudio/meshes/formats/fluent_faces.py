"""The faces of a Fluent file: hexadecimal text, or whole numbers of four or eight bytes."""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import Indices
from ffdstudio.meshes.formats.fluent_mesh import Partners, Side
from ffdstudio.meshes.formats.fluent_sections import Zone
from ffdstudio.meshes.formats.number_table import split_tokens
from ffdstudio.meshes.formats.source import Source
from ffdstudio.meshes.formats.vtkcells import offsets_of


def tokens(source: Source, zone: Zone) -> tuple[Indices, Indices]:
    """Places of the words of a section in text."""
    starts, ends = split_tokens(source.data[zone.begin : zone.end])
    return starts + zone.begin, ends + zone.begin


def _hexadecimal(source: Source, zone: Zone) -> Indices:
    """Numbers of a section, digit by digit for all of them at once."""
    starts, ends = tokens(source, zone)
    digit = np.full(256, 255, dtype=np.uint8)
    for value, letter in enumerate(b"0123456789abcdef"):
        digit[letter] = value
        digit[ord(chr(letter).upper())] = value
    digits = digit[np.frombuffer(source.data, dtype=np.uint8)[zone.begin : zone.end]]
    sizes = ends - starts
    values = np.zeros(len(starts), dtype=np.int64)
    if len(starts) and sizes.max() > 12:
        raise source.error(int(starts[sizes.argmax()]), "not a hexadecimal number")
    for k in range(int(sizes.max(initial=0))):
        longer = sizes > k
        found = digits[starts[longer] - zone.begin + k]
        if (found == 255).any():
            bad = starts[longer][found == 255][0]
            raise source.error(int(bad), "not a hexadecimal number")
        values[longer] = values[longer] * 16 + found
    return values


def side_of(source: Source, zone: Zone, nodes: int) -> Side:
    """Faces of a zone in a mesh of so many nodes.

    Raises
    ------
    InputError
        If they are not as many as announced, or refer to what is not there.
    """
    if not zone.real:
        return _side(source, zone, _hexadecimal(source, zone), nodes)
    wide = (zone.end - zone.begin) % 8 == 0 and _is_wide(source, zone)
    dtype = np.dtype("<i8" if wide else "<i4")
    many = (zone.end - zone.begin) // dtype.itemsize
    values = np.frombuffer(source.data, dtype, many, zone.begin).astype(np.int64)
    return _side(source, zone, values, nodes)


def _is_wide(source: Source, zone: Zone) -> bool:
    """Whether numbers have eight bytes: every second group of four is then zero."""
    halves = np.frombuffer(source.data, "<i4", (zone.end - zone.begin) // 4, zone.begin)
    return len(halves) > 2 and not halves[1::2].any()


def _side(source: Source, zone: Zone, values: Indices, nodes: int) -> Side:
    count = zone.head[2] - zone.head[1] + 1
    size = zone.word(4)
    if size in (2, 3, 4):
        if len(values) != count * (size + 2):
            raise source.error(zone.begin, f"{count} faces announced, not as many found")
        table = values.reshape(count, size + 2)
        flat, offsets, cells = table[:, :size].ravel(), size * np.arange(count + 1), table[:, size:]
    elif size in (0, 5):
        flat, offsets, cells = _mixed(source, zone, values, count)
    else:
        raise source.error(zone.begin, f"faces of type {size} are not known")
    if flat.size and not (flat.min() >= 1 and flat.max() <= nodes):
        raise source.error(zone.begin, f"a face refers to a node that is not in 1 to {nodes}")
    if count < 0 or (cells < 0).any() or ((cells == 0).all(axis=1)).any():
        raise source.error(zone.begin, "a face without cells")
    return Side(zone.head[0], zone.head[1], zone.word(3), flat - 1, offsets, cells)


def _mixed(
    source: Source, zone: Zone, values: Indices, count: int
) -> tuple[Indices, Indices, Indices]:
    """Faces that state their size first."""
    numbers, begins, at = values.tolist(), [], 0
    while at < len(numbers):
        begins.append(at)
        at += numbers[at] + 3
    if at != len(numbers) or len(begins) != count:
        raise source.error(zone.begin, f"{count} faces announced, not as many found")
    first = np.array(begins, dtype=np.int64)
    sizes = values[first]
    ends = first + 1 + sizes
    cells = values[ends[:, None] + np.arange(2)]
    flat = np.delete(values, np.concatenate([first, ends, ends + 1]))
    return flat, offsets_of(sizes), cells


def partners_of(source: Source, zone: Zone) -> Partners:
    """Faces of a periodic zone and of its shadow, from section 18."""
    values = _hexadecimal(source, zone)
    return Partners(zone.word(2), zone.word(3), values[: len(values) // 2 * 2].reshape(-1, 2))
