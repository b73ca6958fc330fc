"""Numbers as papers write them."""

from __future__ import annotations

from typing import Any

MINUS = "−"
NONE = "–"
ROUNDING = 1e-9
"""Two values that differ by less are one."""


def number(value: float | None, digits: int = 2) -> str:
    """Write a number with a real minus sign; a dash where there is none."""
    if value is None:
        return NONE
    text = f"{value:.{digits}f}"
    return text.replace("-", MINUS) if float(text) != 0 else text.lstrip("-")


def fraction(value: float | None, digits: int = 2) -> str:
    """Write a number that cannot exceed 1 without its leading zero (APA)."""
    text = number(value, digits)
    return text.replace("0.", ".", 1) if text.lstrip(MINUS).startswith("0.") else text


def p_value(value: float | None) -> str:
    """Write p with three digits after the point, or four where three would say .050 of others."""
    if value is None:
        return NONE
    if value < 0.001:
        return "<\u00a0.001"
    return fraction(value, 4 if fraction(value, 3) == ".050" and value != 0.05 else 3)


def p_equals(value: float | None) -> str:
    """Write p in a sentence."""
    text = p_value(value)
    return f"p\u00a0{text}" if text.startswith("<") else f"p\u00a0=\u00a0{text}"


def interval(found: Any, digits: int = 2, *, bounded: bool = False, null: float = 0.0) -> str:
    """Write [low, high], with a round bracket where the end itself is not in the interval.

    An end beside the value of no difference, `null`, is not rounded to it.
    """
    if found is None or (found.low is None and found.high is None):
        return NONE
    low, high = found.low, found.high
    write = fraction if bounded else number
    first = "−∞" if low is None else write(low, _digits(low, digits, null))
    last = "∞" if high is None else write(high, _digits(high, digits, null))
    left = "[" if low is not None and getattr(found, "low_closed", True) else "("
    right = "]" if high is not None and getattr(found, "high_closed", True) else ")"
    hole = " without 0" if getattr(found, "holds_rejected_zero", False) else ""
    return f"{left}{first},\u00a0{last}{right}{hole}"


def _digits(end: float, digits: int, null: float) -> int:
    while abs(end - null) > ROUNDING and round(end, digits) == null:
        digits += 1
    return digits


def degrees(value: float) -> str:
    """Write degrees of freedom: whole if they are."""
    return str(int(value)) if float(value).is_integer() else number(value, 2)


def bayes_factor(value: float | None) -> str:
    """Write a Bayes factor: two decimals, or as a power of ten where that would say nothing."""
    if value is None or 0.01 <= value < 10_000:
        return number(value)
    digits, _, power = f"{value:.1e}".partition("e")
    superscript = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{digits}\u00a0×\u00a010{superscript}"
