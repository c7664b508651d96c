"""Reals in the sixteen characters of Nastran's large fields."""

from __future__ import annotations

import re

WIDTH = 16


def sixteen(value: float) -> str:
    """Real number in at most 16 characters, the closest that Nastran's notation allows.

    Examples
    --------
    >>> sixteen(-1 / 3), sixteen(1e-5 / 3), sixteen(2.0)
    ('-.33333333333333', '3.333333333333-6', '2.')
    """
    short = _compact(repr(value))
    if len(short) <= WIDTH:
        return short
    fits = [text for form in "fe" if (text := _longest(value, form))]
    return min(fits, key=lambda text: abs(float(plain(text)) - value))


def _longest(value: float, form: str) -> str:
    """Text with as many digits as fit, fixed (f) or with an exponent (e); empty if none does."""
    for digits in range(15, 3, -1):
        text = _compact(f"{value:.{digits}{form}}")
        if len(text) <= WIDTH:
            return text
    return ""


def _compact(text: str) -> str:
    """Drop the zero before the point and the E of the exponent, as Nastran allows."""
    mantissa, _, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa += "."
    mantissa = re.sub(r"^(-?)0\.(?=\d)", r"\1.", mantissa)
    mantissa = re.sub(r"(?<=\d)0+$", "", mantissa) if "." in mantissa else mantissa
    if mantissa.endswith(".0"):
        mantissa = mantissa[:-1]
    if mantissa.strip("-") == ".":
        mantissa = "0."
    return mantissa + (f"{int(exponent):+d}" if exponent else "")


def plain(text: str) -> str:
    """Nastran's real as others write it."""
    return re.sub(r"(?<=[\d.])([+-])", r"e\1", text)
