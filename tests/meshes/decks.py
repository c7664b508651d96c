"""Decks with what is legal and rare: comments between the lines of a card, blanks, zones."""

from __future__ import annotations

from pathlib import Path

SIXTHS = [(0, 1 / 8, 0), (1, 0, 0), (1, 1, 1 / 16), (0, 1, 0), (0.25, 0.5, 1), (1, 0, 1)]


def nastran_with_comments(path: Path) -> None:
    """Large fields only, so that a moved node keeps its two lines."""
    cards = [
        f"GRID*   {k:>16}{'':16}{x!r:>16}{y!r:>16}*\n$ {k}\n$--\n*       {z!r:>16}\n"
        for k, (x, y, z) in enumerate(SIXTHS, start=1)
    ]
    cell = "CPENTA         1       1       1       2       3       4       5       6\n"
    path.write_text("SOL 101\nCEND\nBEGIN BULK\n" + "".join(cards) + cell + "$ end\nENDDATA\n")


def abaqus_with_blanks(path: Path) -> None:
    """Every zero is left blank."""
    rows = [
        ",".join([str(k), *("" if x == 0 else f" {x!r}" for x in point)])
        for k, point in enumerate(SIXTHS, start=1)
    ]
    path.write_text(
        "*NODE, NSET=all\n" + "\n".join(rows) + "\n*ELEMENT, TYPE=C3D6\n1,1,2,3,4,5,6\n"
    )


def su2_with_boxes(path: Path) -> None:
    """Two zones, each with a box of its own and a comment behind it."""
    box = "FFD_NBOX= 1\nFFD_NLEVEL= 1\nFFD_TAG= {}\nFFD_LEVEL= 0\n% behind the box\n"
    zone = "IZONE= {}\nNDIME= 3\nNELEM= 1\n13 0 1 2 3 4 5 0\nNPOIN= 6\n{}\nNMARK= 0\n"
    text = "NZONE= 2\n"
    for k in (1, 2):
        rows = [f"{x!r} {y!r}\t{k * z!r} {n}" for n, (x, y, z) in enumerate(SIXTHS)]
        text += zone.format(k, "\n".join(rows)) + box.format("AB"[k - 1])
    path.write_text(text)
