"""Causes of failed episodes on their pages, which packages find."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

from cbdsl.reporting.recorded import Recorded
from cbdsl.types.registry import Registry, require_function


class MarkedCause(NamedTuple):
    """Cause of a failure on a page: its kind, its time, s, and its sentence."""

    kind: str
    time: float
    text: str


Finder: TypeAlias = Callable[[Recorded], Sequence[MarkedCause]]
"""Function of a recording that returns the causes of a failure, the first one first."""


DIAGNOSES: Registry[Finder] = Registry(
    "diagnosis", "cbdsl.diagnoses", {}, require_function, providers={"why": "cbdsl[why]"}
)
