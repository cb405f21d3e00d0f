"""Errors in written quantities, and their remedies."""

from __future__ import annotations

import re

from cbdsl.types.unit import NUMBER, UNITS, QuantityError, is_quantity

# Real quantities are shorter; the time of matching grows with the square of the length.
_LONGEST = 200

# A regular expression takes the first alternative that matches, so that ``m/s`` has to come before
# ``m``.
_UNIT = "|".join(re.escape(unit) for unit in sorted(UNITS, key=len, reverse=True))
_ONE = rf"{NUMBER}(?: *(?:{_UNIT})(?![\w/^]))?"
# Inputs that the following patterns match, in their order: ``2 - 5 cm``, ``20 cm,``, ``20 cm#
# wide``, ``2x10^-3 m``, ``1/2``, ``50 %``, ``-pi/2 rad``, ``s 15`` and ``15 sec``.
_SPAN = re.compile(rf"\s*({_ONE})\s*(?:-|\.\.+|to|and|\u2026|~)\s*({_ONE})\s*")
_END = re.compile(r"(?P<core>.*?)\s*(?P<sign>[,;]+)\s*")
_COMMENT = re.compile(r"(?P<core>.*?)\s*(?:#|//)\s*(?P<words>.*)")
_POWER = re.compile(rf"\s*({NUMBER})\s*[x*\xb7\xd7]\s*10\s*(?:\^|\*\*)\s*([+-]?\d+)\s*(.*)")
_FRACTION = re.compile(r"\s*(\d+)\s*/\s*([1-9]\d*)\s*")
_PERCENT = re.compile(rf"\s*({NUMBER})\s*%\s*")
_PI = re.compile(
    r"\s*(?P<sign>[+-]?)(?P<times>\d*)\s*\*?\s*pi\s*(?:/\s*(?P<by>[1-9]\d*))?(?: *rad)?\s*"
)
_REVERSED = re.compile(rf"\s*([a-zA-Z/][\w/^]*)\s*({NUMBER})\s*")
_WITH_UNIT = re.compile(rf"\s*({NUMBER})\s*(\S.*?)\s*")
_OTHER_NAMES = {
    "s": "sec secs second seconds",
    "ms": "msec millisecond milliseconds",
    "min": "minute minutes",
    "deg": "degree degrees",
    "rad": "radian radians",
    "m": "meter meters metre metres",
    "cm": "centimeter centimeters centimetre centimetres",
    "mm": "millimeter millimeters millimetre millimetres",
    "kg": "kilogram kilograms kilo",
    "g": "gram grams",
    "N": "newton newtons Newton",
    "N m": "N*m N.m N-m",
    "Hz": "hertz Hertz 1/sec",
    "px": "pixel pixels",
    "m/s^2": "m/s2 m/s/s m/s**2",
    "cm/s^2": "cm/s2 cm/s/s cm/s**2",
    "rad/s^2": "rad/s2 rad/s/s rad/s**2",
    "deg/s^2": "deg/s2 deg/s/s deg/s**2",
    "m/s": "m/sec mps",
    "rad/s": "rad/sec",
    "deg/s": "deg/sec",
}


def problem_in(value: object) -> str | None:
    """Return the fault of a value that should be a quantity, and its remedy, as a clause."""
    if isinstance(value, str):
        if len(value) > _LONGEST:
            return None
        clauses = (explain(value) for explain in _EXPLANATIONS)
        return next((clause for clause in clauses if clause is not None), None)
    parts = _parts(value)
    if not parts:
        return None
    joined = " ".join(parts)
    if is_quantity(joined):
        return f"a quantity is a number and its unit; write '{joined}'"
    if len(parts) == 2 and all(map(is_quantity, parts)) and isinstance(value, dict):
        return f"a span is a list of two values; write [{', '.join(parts)}]"
    return None


def quantity_problem(value: object, error: QuantityError) -> str:
    """Return the message for a value that is not a quantity: its remedy, or the required unit.

    The remedy is not part of the error's message, since that also serves values that may be text.
    """
    message = str(error)
    return (
        message.partition("; expected")[0] if "; write" in message else problem_in(value) or message
    )


def quantities_in(text: str) -> list[str]:
    """Return the quantities of a text, without brackets and commas; empty for other contents."""
    if len(text) > _LONGEST:
        return []
    inner = text.strip().strip("[](){}").strip()
    parts = [part.strip() for part in inner.split(",")]
    if len(parts) == 1:
        parts = re.findall(_ONE, inner)
        if re.sub(r"\s", "", "".join(parts)) != re.sub(r"\s", "", inner):
            return []
    return parts if all(map(is_quantity, parts)) else []


def _parts(value: object) -> list[str]:
    inner = list(value.values()) if isinstance(value, dict) else value
    if not isinstance(inner, list) or len(inner) > 2:
        return []
    return [str(part) for part in inner if isinstance(part, (str, int, float))]


def _end(text: str) -> str | None:
    match = _END.fullmatch(text)
    if match is None or not is_quantity(match["core"]):
        return None
    return f"leave out the '{match['sign']}' at the end; write '{match['core']}'"


def _comment(text: str) -> str | None:
    match = _COMMENT.fullmatch(text)
    if match is None or not is_quantity(match["core"]):
        return None
    return f"a comment begins with a space and '#'; write '{match['core']} # {match['words']}'"


def _span(text: str) -> str | None:
    match = _SPAN.fullmatch(text)
    if match is None or not all(map(is_quantity, match.groups())):
        return None
    # In ``2 - 5 cm``, the unit of the last number is meant for both.
    first = match[1]
    if re.fullmatch(NUMBER, first):
        first += re.sub(rf"^{NUMBER}", "", match[2])
    return f"a span is a list of two values; write [{first}, {match[2]}]"


def _list(text: str) -> str | None:
    parts = quantities_in(text)
    if len(parts) < 2:
        return None
    return f"a list is written in brackets; write [{', '.join(parts)}]"


def _power(text: str) -> str | None:
    match = _POWER.fullmatch(text)
    if match is None:
        return None
    number = " ".join(filter(None, (f"{match[1]}e{match[2]}", match[3])))
    return f"powers of ten are written with 'e'; write '{number}'"


def _share(text: str) -> str | None:
    if percent := _PERCENT.fullmatch(text):
        return f"nothing is given in percent; write {float(percent[1]) / 100:g}"
    fraction = _FRACTION.fullmatch(text)
    number = int(fraction[1]) / int(fraction[2]) if fraction else None
    return None if number is None else f"nothing is computed here; write {number:g}"


def _pi(text: str) -> str | None:
    match = _PI.fullmatch(text)
    if match is None:
        return None
    degrees = 180 * int(match["times"] or 1) / int(match["by"] or 1)
    return f"nothing is computed here; write '{match['sign']}{degrees:g} deg'"


def _reversed(text: str) -> str | None:
    match = _REVERSED.fullmatch(text)
    if match and match[1] in UNITS:
        return f"the number stands before its unit; write '{match[2]} {match[1]}'"
    return f"'{text}' is a unit, and its number is missing" if text.strip() in UNITS else None


def _unit(text: str) -> str | None:
    """Return the remedy for a unit with another name, or with wrong upper and lower case."""
    match = _WITH_UNIT.fullmatch(text)
    if match is None or match[2] in UNITS:
        return None
    other = (unit for unit, names in _OTHER_NAMES.items() if match[2] in names.split())
    letters = (unit for unit in UNITS if unit.lower() == match[2].lower())
    unit = next(other, None) or next(letters, None)
    return f"'{match[2]}' is not a unit; write '{match[1]} {unit}'" if unit else None


_EXPLANATIONS = (_end, _comment, _power, _span, _list, _share, _pi, _reversed, _unit)
