"""What a field of a description is called, means and may hold.

Everything that is said of a field is said once, in its annotation: the form, the messages, the
JSON schema and the reference page are made from it.
"""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

DISTINCT = "distinct"


def says(title: str, text: str, unit: str = "", form: bool = True, file: bool = False) -> Meta:
    """Title, meaning and unit of a field.

    Parameters
    ----------
    title : str
        As the form writes it.
    text : str
        What the field means, a phrase without a full stop.
    unit : str
        Empty for a pure number.
    form : bool
        Whether the window's form offers it; what it does not offer it keeps.
    file : bool
        Whether it names a file that can be chosen.

    Examples
    --------
    >>> says("Angle", "of attack", "°").title
    'Angle'
    """
    return Meta(title=title, description=text, extra={"unit": unit, "form": form, "file": file})


def distinct(least: int = 1) -> Meta:
    """A list of at least so many values, no two of them alike."""
    return Meta(
        min_length=least, extra={DISTINCT: True}, extra_json_schema={"uniqueItems": True}
    )  # fmt: skip


Letter = Literal["x", "y", "z"]
Axis = Literal["i", "j", "k"]
Text = Annotated[str, Meta(min_length=1, pattern=r"\S")]
Count = Annotated[int, Meta(ge=1)]
Index = Annotated[int, Meta(ge=0)]
Positive = Annotated[float, Meta(gt=0)]
Weight = Annotated[float, Meta(ge=0)]
Angle = Annotated[float, Meta(ge=-90, le=90)]
Processes = Annotated[int, Meta(ge=1, le=256)]
