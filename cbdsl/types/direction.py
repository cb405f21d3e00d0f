"""Directions of impedance tests: along and about the axes of the world frame (Figure 7.13)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args

AXES = "xyz"
#: Prefix of a direction's name by the kind of the load that is tracked.
KINDS: Mapping[str, str] = {"force": "dP", "torque": "dR"}

Direction = Literal["dPx", "dPy", "dPz", "dRx", "dRy", "dRz"]
DIRECTIONS: tuple[str, ...] = get_args(Direction)


def unit_of(direction: str) -> str:
    """Return the SI unit of the impedance in a direction."""
    return "N/m" if direction.startswith(KINDS["force"]) else "N m/rad"
