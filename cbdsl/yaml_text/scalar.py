"""What an unquoted scalar means: the core schema of YAML 1.2, with ``1e-3`` as a number.

Reader and writer share these patterns, so that what is written reads back as it was. YAML 1.1's
surprises (``NO`` as false, ``0755`` as 493, ``12:30:45`` as 45045) do not exist here.
"""

from __future__ import annotations

import re

NULL = re.compile(r"(?:~|null|Null|NULL|)\Z")
BOOLEAN = re.compile(r"(?:true|True|TRUE|false|False|FALSE)\Z")
INTEGER = re.compile(r"[-+]?[0-9]+\Z")
FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+\.?[0-9]*)(?:[eE][-+]?[0-9]+)?\Z")
NOT_FINITE = re.compile(r"(?:[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))\Z")
LEADING_ZERO = re.compile(r"[-+]?0[0-9]+\Z")

# What a scalar of these patterns can begin with: most texts need no match at all.
_FIRST = frozenset("~nNtTfF+-.0123456789")

Scalar = str | int | float | bool | None


class ScalarError(ValueError):
    """A scalar that no document may hold; ``code`` is the catalogue's."""

    def __init__(self, code: str) -> None:
        super().__init__(code)
        self.code = code


def resolve(text: str) -> Scalar:
    """The value of a plain (unquoted) scalar.

    Raises:
        ScalarError: it is not finite, or is an integer that YAML 1.1 would read as octal.
    """
    if text and text[0] not in _FIRST:
        return text
    if NULL.match(text):
        return None
    if BOOLEAN.match(text):
        return text[0] in "tT"
    if NOT_FINITE.match(text):
        raise ScalarError("CB109")
    if LEADING_ZERO.match(text):
        raise ScalarError("CB110")
    return _number(text)


def _number(text: str) -> Scalar:
    if INTEGER.match(text):
        # Python refuses to read integers of thousands of digits.
        return int(text) if len(text) < 400 else float(text)
    return float(text) if FLOAT.match(text) else text
