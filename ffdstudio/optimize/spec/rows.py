"""What the rows of the catalog have in common."""

from __future__ import annotations

from typing import ClassVar, Literal

import msgspec

from ffdstudio.optimize.spec.words import sentence_of

Kind = Literal["section", "surface", "any"]


class Part(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True,
           omit_defaults=True):  # fmt: skip
    """A table of a description; `table` is its name in files."""

    table: ClassVar[str] = ""
    title: ClassVar[str] = ""


class Row(Part, frozen=True, tag_field="kind"):
    """One kind of objective, constraint or method: a row of the catalog.

    Attributes
    ----------
    title : str
        For people.
    needs : {"section", "surface", "any"}
        The shape that it is about.
    """

    needs: ClassVar[Kind] = "any"

    @classmethod
    def kind(cls) -> str:
        """Word for it in files."""
        return str(cls.__struct_config__.tag)

    @classmethod
    def about(cls) -> str:
        """What it does, in a sentence."""
        return sentence_of(cls.__doc__)
