"""Parameters within texts: ``$name`` stands for a value."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

_PARAMETER = re.compile(r"\$([A-Za-z][A-Za-z0-9_]*)")
# A reference may negate a parameter, as in ``[30 cm, -$side]``. For the value ``-10 cm``, plain
# replacement would give ``--10 cm``, which is not a quantity.
_NEGATED = re.compile(r"(^|[\[,])(\s*)-\$([A-Za-z][A-Za-z0-9_]*)")


def parameters_in(text: str) -> Iterator[re.Match[str]]:
    """Yield each ``$name`` of a text; the first group of a match is the name."""
    return _PARAMETER.finditer(text)


def filled(text: str, values: Mapping[str, str]) -> str:
    """Return a text with the parameters replaced that have values."""

    def negated(match: re.Match[str]) -> str:
        """Return a quantity with the opposite sign: two signs of a negative one cancel."""
        value = values.get(match[3], "").lstrip()
        return f"{match[1]}{match[2]}{value[1:]}" if value.startswith("-") else match[0]

    return _PARAMETER.sub(lambda match: values.get(match[1], match[0]), _NEGATED.sub(negated, text))
