"""The sections of an SU2 file, by zone."""

from __future__ import annotations

from typing import NamedTuple

from ffdstudio.meshes.formats.source import Source


class Su2Section(NamedTuple):
    """A line ``KEY= value`` at `place`, and the place of the lines that follow it."""

    key: bytes
    value: bytes
    place: int
    begin: int
    end: int


def sections_of(source: Source) -> list[Su2Section]:
    """All sections, found by their equals sign: numbers have none."""
    data, found = source.data, []
    at = data.find(b"=")
    while at >= 0:
        begin, end = data.rfind(b"\n", 0, at) + 1, source.line_end(at)
        key = data[begin:at].strip()
        if b"%" not in key:
            found.append((key, data[at + 1 : end].split(b"%")[0].strip(), begin, end))
            if not key.replace(b"_", b"").isalnum():
                shown = key[:20].decode("latin-1")
                raise source.error(begin, f"expected a keyword before '=', found {shown!r}")
        at = data.find(b"=", end)
    ends = [*(place for _, _, place, _ in found[1:]), len(data)][: len(found)]
    return [Su2Section(*row, end) for row, end in zip(found, ends, strict=True)]


def zones_of(source: Source, sections: list[Su2Section]) -> list[tuple[str, list[Su2Section]]]:
    """Sections by zone; the name is empty where there is only one."""
    zones: list[tuple[str, list[Su2Section]]] = [("", [])]
    declared = 1
    for section in sections:
        if section.key == b"NZONE":
            declared = source.integer(section.value, section.place, "NZONE=", 1)
        elif section.key == b"IZONE":
            zones.append((f"zone {section.value.decode('latin-1')}", []))
        else:
            zones[-1][1].append(section)
    if len(zones) > 1 and not any(section.key == b"NPOIN" for section in zones[0][1]):
        # what stands before the first zone is said of all of them
        _, common = zones.pop(0)
        keys = [{section.key for section in part} for _, part in zones]
        for own, (_, part) in zip(keys, zones, strict=True):
            part += [section for section in common if section.key not in own]
    if len(zones) != declared:
        raise source.failure(f"NZONE= announces {declared} zones, the file has {len(zones)}")
    return zones if declared > 1 else [("", zones[0][1])]


def ffd_spans(source: Source, sections: list[Su2Section]) -> tuple[tuple[int, int], ...]:
    """Places of the FFD sections, one a zone: keywords that follow each other.

    What stands between two of them belongs to the mesh, and so do comments behind the last line.
    """
    spans: list[tuple[int, int]] = []
    for section in sections:
        if not section.key.startswith(b"FFD_"):
            continue
        begin = section.place
        if spans and spans[-1][1] == begin:
            begin = spans.pop()[0]
        spans.append((begin, section.end))
    return tuple((begin, _last_line_end(source, begin, end)) for begin, end in spans)


def _last_line_end(source: Source, begin: int, end: int) -> int:
    """End of the last line that is neither blank nor a comment."""
    while end > begin:
        line = source.data.rfind(b"\n", begin, end - 1) + 1 or begin
        if source.data[line:end].split(b"%")[0].strip():
            break
        end = line
    return end
