"""Values of unquoted scalars: the core schema of YAML 1.2, with ``1e-3`` as a number.

Reader and writer share these patterns, so that what is written reads back as it was. Where YAML 1.1
has another meaning (``NO`` as false, ``0755`` as 493, ``12:30:45`` as 45045) the text is refused: a
document means the same to every reader, or nothing.
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
# What PyYAML reads as true or false; the y and n of YAML 1.1 it leaves alone, and they are axes.
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
# What most numbers look like, and nothing that is refused.
_SIMPLE = re.compile(r"-?(?:0|[1-9][0-9]{0,8})(?:\.[0-9]{1,9})?\Z")
# The largest integer up to which a 64-bit float holds every one.
_LARGEST = 2**53

# What a scalar of these patterns can begin with: most texts need no match at all.
_FIRST = frozenset("~nNtTfFyYoO+-.0123456789")

Scalar = str | int | float | bool | None


class ScalarError(ValueError):
    """A scalar that no document may hold; ``code`` is the catalogue's."""

    def __init__(self, code: str) -> None:
        super().__init__(code)
        self.code = code


def resolve(text: str) -> Scalar:
    """The value of a plain (unquoted) scalar.

    Raises:
        ScalarError: YAML 1.1 would read it as something else, or no number of 64 bits holds it.
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
    if math.isinf(number) or (number == 0 and re.search("[1-9]", mantissa)):
        raise ScalarError("CB120")
    return number
