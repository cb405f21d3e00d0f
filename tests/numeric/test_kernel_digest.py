"""Digests change only with the inputs of machine code."""

from __future__ import annotations

from types import FunctionType
from typing import Any

import pytest

from cbdsl.numeric.kernel_digest import NoDigestError, digest_of

TEXT = '''
from enum import IntEnum
from math import sin
from numba import njit
import numpy as np

RATE = 2.0
TABLE = np.array([1.0, 2.0])

class Mode(IntEnum):
    OFF = 0
    ON = 1

@njit
def inner(x):
    """Inner."""
    return sin(x) + TABLE[0]

def outer(x):
    """Outer."""
    return RATE * inner(x) + Mode.ON
'''


def digest(*changes: tuple[str, str], options: str = "") -> str:
    text = TEXT
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    scope: dict[str, Any] = {"__name__": "module"}
    exec(text, scope)
    outer = scope["outer"]
    assert isinstance(outer, FunctionType)
    return digest_of(outer, options)


@pytest.mark.parametrize(
    "change",
    [
        ('"""Outer."""', '"""Another docstring."""'),
        ('"""Inner."""', '"""Another docstring."""'),
        ("\n@njit", "\n# A comment.\n\n\n@njit"),
    ],
)
def test_digest_of_ignores_documentation_and_places(change: tuple[str, str]) -> None:
    assert digest(change) == digest()


@pytest.mark.parametrize(
    "change",
    [
        ("RATE = 2.0", "RATE = 3.0"),
        ("RATE = 2.0", "RATE = 2"),
        ("[1.0, 2.0]", "[1.0, 2.5]"),
        ("TABLE[0]", "TABLE[1]"),
        ("RATE * inner", "RATE / inner"),
        ("import sin", "import cos as sin"),
        ("ON = 1", "ON = 2"),
        ("@njit", "@njit(fastmath=True)"),
        ("def inner(x)", "def inner(x, y=1.0)"),
    ],
)
def test_digest_of_changes_with_code_and_values(change: tuple[str, str]) -> None:
    assert digest(change) != digest()


def test_digest_of_changes_with_options() -> None:
    assert digest(options="fastmath") != digest()


def test_digest_of_refuses_a_value_that_it_cannot_describe() -> None:
    with pytest.raises(NoDigestError, match="object"):
        digest(("RATE = 2.0", "RATE = object()"))
