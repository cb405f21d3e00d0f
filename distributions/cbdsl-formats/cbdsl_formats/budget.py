"""Bounds on the work that a model's macros and expressions may request."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: Characters of a text, parts of a list or dictionary including nested ones, and bits of a number.
MOST_PARTS = 10_000

# A public humanoid's model takes some 100,000; this number takes a few seconds.
_MOST_STEPS = 5_000_000


class BudgetError(ValueError):
    """Request of a model for more work or larger values than any real model needs."""


class StepBudget:
    """Remaining steps of an expansion."""

    def __init__(self) -> None:
        self._steps = _MOST_STEPS

    def spend(self, steps: int) -> None:
        """Subtract steps from the remaining ones.

        Raises:
            BudgetError: If fewer are left.
        """
        self._steps -= steps
        if self._steps < 0:
            raise BudgetError(
                f"its macros take more than {_MOST_STEPS} steps; does one of them use itself?"
            )

    def require_small(self, value: Any) -> None:
        """Check the size of a value, including nested ones, and take a step for each part.

        Raises:
            BudgetError: If it is too large, or fewer steps are left.
        """
        if isinstance(value, list | tuple | Mapping | set | frozenset):
            self.spend(_parts(value))
        elif isinstance(value, str):
            require_small(len(value))
        elif isinstance(value, int):
            require_small(value.bit_length())


def require_small(size: int) -> None:
    """Check the size of a value before it is created.

    Raises:
        BudgetError: If it is too large.
    """
    if size > MOST_PARTS:
        raise BudgetError(f"a value has more than {MOST_PARTS} characters, parts or bits")


def _parts(value: Any) -> int:
    """Return the number of parts of a nested value; a shared part counts each time."""
    # A list whose two items are the same list, over some levels, takes little memory but expands to
    # gigabytes of text. Shared parts are thus counted each time, and the bound ends the count
    # early. A stack replaces recursion, whose depth the model could choose.
    count, left = 0, [value]
    while left:
        part = left.pop()
        count += len(part) if isinstance(part, str) else 1
        require_small(count + len(left))
        if isinstance(part, Mapping):
            require_small(len(part))
            left += [*part.keys(), *part.values()]
        elif isinstance(part, list | tuple | set | frozenset):
            require_small(len(part))
            left += part
    return count
