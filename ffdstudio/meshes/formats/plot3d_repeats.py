"""Numbers that a list-directed text repeats (``6*0.0``): read, and written out where they part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffdstudio.aliases import Array, Indices
from ffdstudio.files import write_bytes
from ffdstudio.meshes.formats.number_table import pick_anywhere
from ffdstudio.meshes.formats.patch import changed, refuse_missing_axes, shortest
from ffdstudio.meshes.formats.source import Source

MOST = 1000  # times the size of the file: values that repeats may make


@dataclass(frozen=True, eq=False)
class Repeats:
    """(n,) values of a text: begin and end of the number of each, and the word it stands in."""

    source: Source
    starts: Indices
    ends: Indices
    words: Indices  # (n,) word of each value
    spans: Indices  # (words, 2) begin and end of the words
    repeated: bool

    @classmethod
    def of(cls, source: Source, starts: Indices, ends: Indices) -> Repeats:
        """Values of words, those with a star as often as they say.

        Raises
        ------
        InputError
            If a repeat is no count, or larger than a file can mean.
        """
        spans = np.stack([starts, ends], axis=1)
        stars = np.flatnonzero(np.frombuffer(source.data, dtype=np.uint8) == ord("*"))
        counts, begins = np.ones(len(starts), dtype=np.int64), starts.copy()
        for star in stars.tolist():
            word = int(np.searchsorted(starts, star, side="right")) - 1
            count = source.data[starts[word] : star] if word >= 0 else b""
            counts[word] = source.integer(count, star, "how often a number is repeated", 1)
            begins[word] = star + 1
        if counts.astype(float).sum() > MOST * len(source.data):
            raise source.failure("numbers are repeated more often than a mesh can mean")
        words = np.repeat(np.arange(len(starts)), counts)
        return cls(source, begins[words], ends[words], words, spans, len(stars) > 0)

    def template(self, places: Indices) -> RepeatTemplate:
        """Template whose (n, axes) coordinates are these values."""
        once, inverse = np.unique(self.words[places], return_inverse=True)
        first = np.searchsorted(self.words, once)
        values = pick_anywhere(self.source, self.starts[first], self.ends[first])
        points = np.zeros((len(places), 3))
        points[:, : places.shape[1]] = values[inverse].reshape(places.shape)
        return RepeatTemplate(self, points, places)


@dataclass(frozen=True, eq=False)
class RepeatTemplate:
    """A text with repeats: a word is written out if one of the values in it changes."""

    repeats: Repeats
    original: Array
    places: Indices

    def patched(self, points: Array) -> bytes:
        """File content with these (n, 3) coordinates."""
        axes = self.places.shape[1]
        refuse_missing_axes(self.original, points, axes)
        moved = changed(self.original, points)[:, :axes]
        data, repeats = self.repeats.source.data, self.repeats
        new = dict(zip(self.places[moved].tolist(), points[:, :axes][moved].tolist(), strict=True))
        pieces, at = [], 0
        for word in np.unique(repeats.words[self.places[moved]]).tolist():
            low, high = np.searchsorted(repeats.words, [word, word + 1]).tolist()
            own = data[repeats.starts[low] : repeats.ends[low]]
            texts = [shortest([new[k]])[0].encode() if k in new else own for k in range(low, high)]
            begin, end = repeats.spans[word].tolist()
            pieces += [data[at:begin], b" ".join(texts)]
            at = end
        return b"".join([*pieces, data[at:]])

    def write(self, path: Path, points: Array) -> None:
        """Write the patched file."""
        write_bytes(path, self.patched(points))
