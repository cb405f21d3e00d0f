"""Values of unquoted scalars: the core schema of YAML 1.2, with ``1e-3`` as a number.

Reader and writer share these patterns, so that written values read back unchanged. A text to which
YAML 1.1 gives another meaning is refused (``NO`` as false, ``0755`` as 493, ``12:30:45`` as 45045).
An accepted document therefore has the same meaning for every reader.
"""

from __future__ import annotations

import math
import re

NULL = re.compile(r"(?:~|null|Null|NULL|)\Z")
BOOLEAN = re.compile(r"(?:true|True|TRUE|false|False|FALSE)\Z")
INTEGER = re.compile(r"[-+]?[0-9]+\Z")
FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+\.?[0-9]*)(?:[eE][-+]?[0-9]+)?\Z")
NOT_FINITE = re.compile(r"(?:[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))\Z")
LEADING_ZERO = re.compile(r"[-+]?0[0-9]+\Z")
# Words that PyYAML reads as true or false; it keeps y and n as texts, and they name axes.
WORD = re.compile(r"(?:yes|Yes|YES|no|No|NO|on|On|ON|off|Off|OFF)\Z")
SEXAGESIMAL = re.compile(r"[-+]?[0-9][0-9_]*(?::[0-5]?[0-9])+(?:\.[0-9_]*)?\Z")
# Hexadecimal, octal and binary numbers, and digits in groups.
FOREIGN = re.compile(
    r"[-+]?(?:0x[0-9a-fA-F_]+|0o[0-7_]+|0b[01_]+|(?=[0-9]*_)[0-9][0-9_]*(?:\.[0-9_]*)?)\Z"
)
#: Texts that no document may hold without quotes, and their codes in the catalogue.
REFUSED = {
    NOT_FINITE: "CB109",
    LEADING_ZERO: "CB110",
    WORD: "CB114",
    SEXAGESIMAL: "CB115",
    FOREIGN: "CB116",
}
# Form of most numbers; it matches no refused text.
_SIMPLE = re.compile(r"-?(?:0|[1-9][0-9]{0,8})(?:\.[0-9]{1,9})?\Z")
# Largest integer up to which 64-bit floats represent all integers exactly.
_LARGEST = 2**53

# First characters of scalars that match a pattern: most texts need no match at all.
_FIRST = frozenset("~nNtTfFyYoO+-.0123456789")

Scalar = str | int | float | bool | None


class ScalarError(ValueError):
    """Scalar that no document may hold; ``code`` refers to the catalogue of diagnostics."""

    def __init__(self, code: str) -> None:
        super().__init__(code)
        self.code = code


def resolve(text: str) -> Scalar:
    """Return the value of a plain (unquoted) scalar.

    Raises:
        ScalarError: YAML 1.1 would read another value, or the number does not fit into 64 bits.
    """
    # No pattern has a space, which most quantities have.
    if text and (text[0] not in _FIRST or " " in text):
        return text
    if _SIMPLE.match(text):
        return float(text) if "." in text else int(text)
    if NULL.match(text):
        return None
    if BOOLEAN.match(text):
        return text[0] in "tT"
    for pattern, code in REFUSED.items():
        if pattern.match(text):
            raise ScalarError(code)
    return _number(text)


def _number(text: str) -> Scalar:
    if INTEGER.match(text):
        # Python refuses to read integers of thousands of digits.
        if len(text) > 20 or abs(int(text)) > _LARGEST:
            raise ScalarError("CB120")
        return int(text)
    if not FLOAT.match(text):
        return text
    number = float(text)
    mantissa = re.split("[eE]", text)[0]
    # 1e400 exceeds the range of a float, and 1e-400 becomes 0.
    if math.isinf(number) or (number == 0 and re.search("[1-9]", mantissa)):
        raise ScalarError("CB120")
    return number
