"""Numbers that are typed while something is dragged: they take the place of the mouse.

1. Digits begin a number, Tab goes on to the next field, Backspace takes back, and what is typed
   may be an expression: ``0.1/3``, ``=2*(1.5-1)``. Only arithmetic is understood: the text is
   parsed, never executed.
2. A text that is no number yet (``-``, ``2*``) counts as the last one that was.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable
from dataclasses import dataclass, replace

CHARACTERS = "0123456789.,+-*/()=e"
MOST = 40  # characters
OPERATORS: dict[type[ast.AST], Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


def evaluated(text: str) -> float | None:
    """Value of an arithmetic expression; None if it is none, or not finite.

    Examples
    --------
    >>> evaluated("=2*(1.5-1)"), evaluated("-0,25"), evaluated("2*"), evaluated("1/0")
    (1.0, -0.25, None, None)
    """
    try:
        tree = ast.parse(text.lstrip("= ").replace(",", "."), mode="eval")
        value = float(_value(tree.body))
    except (SyntaxError, ValueError, ZeroDivisionError, OverflowError, RecursionError, MemoryError):
        return None
    return value if math.isfinite(value) else None


def _value(node: ast.AST) -> float:
    match node:
        case ast.Constant(value=int() | float() as value):
            return float(value)
        case ast.UnaryOp(op=op, operand=inner) if type(op) in OPERATORS:
            return OPERATORS[type(op)](_value(inner))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            return OPERATORS[type(op)](_value(left), _value(right))
    raise ValueError("only arithmetic")


@dataclass(frozen=True)
class Typed:
    """What has been typed so far: a text for each field, the numbers it means, the field.

    Examples
    --------
    >>> typed = Typed.fields(3)
    >>> for key in ("0", ".", "5", "Tab", "-", "2"):
    ...     typed = typed.took(key)
    >>> typed.values, typed.text(("x", "y", "z"))
    ((0.5, -2.0, 0.0), 'x 0.5   y -2|   z 0')
    """

    texts: tuple[str, ...]
    values: tuple[float, ...]
    field: int = 0

    @classmethod
    def fields(cls, count: int) -> Typed:
        """Nothing typed, in so many fields."""
        return cls(("",) * count, (0.0,) * count)

    @property
    def empty(self) -> bool:
        """Whether nothing is left of what was typed."""
        return not any(self.texts)

    def took(self, key: str) -> Typed:
        """After another key: a character, ``Tab`` or ``Backspace``."""
        if key == "Tab":
            return replace(self, field=(self.field + 1) % len(self.texts))
        old = self.texts[self.field]
        text = old[:-1] if key == "Backspace" else (old + key)[:MOST]
        found = evaluated(text)
        value = 0.0 if not text else self.values[self.field] if found is None else found
        texts, values = list(self.texts), list(self.values)
        texts[self.field], values[self.field] = text, value
        return replace(self, texts=tuple(texts), values=tuple(values))

    def text(self, names: tuple[str, ...]) -> str:
        """Read-out, with a mark where the next character goes."""
        shown = [text or "0" for text in self.texts]
        shown[self.field] = self.texts[self.field] + "|"
        return "   ".join(f"{n} {t}".strip() for n, t in zip(names, shown, strict=True))


def is_typing(key: str) -> bool:
    """Whether a key is for a number.

    Examples
    --------
    >>> is_typing("7"), is_typing("Tab"), is_typing("X")
    (True, True, False)
    """
    return key in ("Tab", "Backspace") or (len(key) == 1 and key in CHARACTERS)
