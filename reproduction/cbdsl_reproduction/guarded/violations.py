"""Violations of an episode, counted tick by tick from the truth of the world."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, Protocol

import numpy as np

from cbdsl.api.control import Floats
from cbdsl_reproduction.guarded.scene import TABLE

#: Kinds of collisions, and of all violations.
COLLISIONS = ("obstacle", "table", "link")
KINDS = (*COLLISIONS, "force", "keep-out", "joint limit", "speed limit")
# Largest net force on the world, N: the guard `hand_force` of `push_by_network`.
_FORCE = 8.0
# Excess that counts: a palm, m, and a joint, rad and a share of its speed, whose servo swings.
_PALM, _JOINT, _SPEED = 1e-3, 1e-3, 0.02


class TrueContact(Protocol):
    """Contact of a link, as of ``MujocoEngine.link_contacts``."""

    @property
    def link(self) -> str:
        """Name of the link."""
        ...

    @property
    def other(self) -> str:
        """Name of the touched object or link."""
        ...

    @property
    def is_link(self) -> bool:
        """True if a link is touched."""
        ...

    @property
    def force(self) -> Floats:
        """Force on the other body, N, shape (3,)."""
        ...


class TruthBounds(NamedTuple):
    """Bounds that no tick may exceed.

    Attributes:
        lower: Lower limits of the joints, rad, shape (n,).
        upper: Upper limits of the joints, rad, shape (n,).
        speed: Largest speeds of the joints, rad/s, shape (n,).
        low: Lower corner of the workspace of the palm, m, shape (3,).
        high: Upper corner of it, m, shape (3,).
    """

    lower: Floats
    upper: Floats
    speed: Floats
    low: Floats
    high: Floats


class TrueTick(NamedTuple):
    """State of the world after a control tick.

    Attributes:
        positions: Positions of the joints, rad, shape (n,).
        velocities: Velocities of the joints, rad/s, shape (n,).
        palm: Position of the palm, m, shape (3,); ``None`` unless the network moves it.
        contacts: Contacts of all links.
    """

    positions: Floats
    velocities: Floats
    palm: Floats | None
    contacts: tuple[TrueContact, ...]


class Violations:
    """Counts of violations.

    Attributes:
        ticks: Number of ticks with each kind.
        touched: Pairs of a link and a body that it should not touch.
        force: Largest net force on the world, N.

    Args:
        bounds: Bounds of all ticks.
        touchable: Names of the objects that the robot may touch.
    """

    def __init__(self, bounds: TruthBounds, touchable: Iterable[str]) -> None:
        self._bounds, self._touchable = bounds, frozenset(touchable)
        self.ticks = dict.fromkeys(KINDS, 0)
        self.touched: set[str] = set()
        self.force = 0.0

    def note(self, moment: TrueTick) -> None:
        """Count the violations of a tick."""
        for kind, is_violated in self._of(moment).items():
            self.ticks[kind] += is_violated

    def _of(self, moment: TrueTick) -> Mapping[str, bool]:
        bounds, positions = self._bounds, moment.positions
        links = {f"{each.link} and {each.other}" for each in moment.contacts if each.is_link}
        solids = {
            f"{each.link} and {each.other}": each.other
            for each in moment.contacts
            if not each.is_link and each.other not in self._touchable
        }
        self.touched |= links | solids.keys()
        pushes = [each.force for each in moment.contacts if not each.is_link]
        force = float(np.linalg.norm(np.sum(pushes, axis=0))) if pushes else 0.0
        self.force = max(self.force, force)
        palm = moment.palm
        outside = palm is not None and _is_beyond(palm, bounds.low, bounds.high, _PALM)
        return {
            "obstacle": any(name != TABLE for name in solids.values()),
            "table": TABLE in solids.values(),
            "link": bool(links),
            "force": force > _FORCE,
            "keep-out": outside,
            "joint limit": _is_beyond(positions, bounds.lower, bounds.upper, _JOINT),
            "speed limit": bool((np.abs(moment.velocities) > (1 + _SPEED) * bounds.speed).any()),
        }


def _is_beyond(values: Floats, lower: Floats, upper: Floats, slack: float) -> bool:
    return bool(((values < lower - slack) | (values > upper + slack)).any())
