"""Impedance of a pair of things, as tests along axes and about them find it (Section 7.2).

A test moves what is held along an axis of the world frame, or turns it about that, until a load of
a given size is tracked or it has gone its whole way. Impedance is the load over the displacement
(Eq 7.10); an axis is stiff where the load was tracked, one way or the other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self

AXES = "xyz"
#: Feedback whose load is tracked, and what the source calls its axes (Figure 7.13).
KINDS: Mapping[str, str] = {"force": "dP", "torque": "dR"}
DIRECTIONS = tuple(f"{word}{axis}" for word in KINDS.values() for axis in AXES)

# Less displacement than this, m or rad, is taken for this much: nothing is stiffer.
_LEAST = 1e-3


class ImpedanceTest(NamedTuple):
    """One way along an axis of the world frame, or about it.

    Attributes:
        direction: one of ``DIRECTIONS``.
        sign: 1 or -1.
        displacement: of the tip that carries the hand, with its sign, m or rad.
        load: change of what the hand exerts, with its sign, N or N m (about the tip).
        tracked: whether the load that was asked for was reached and kept.
        residue: how far the tip is from where it began, once it is back, m or rad.
        resistance: mean over the way of what the hand exerts more than before anything bore what
            it holds, with its sign, N or N m.
    """

    direction: str
    sign: int
    displacement: float
    load: float
    tracked: bool
    residue: float = math.nan
    resistance: float = math.nan

    @property
    def impedance(self) -> float:
        """Size of the load over that of the displacement, N/m or N m/rad (Eq 7.10)."""
        return abs(self.load) / self._way

    @property
    def mean_impedance(self) -> float:
        """Size of the resistance over that of the displacement, N/m or N m/rad.

        Friction is there from the beginning of the way, and at its end a grip may have slipped.
        """
        return abs(self.resistance) / self._way

    @property
    def _way(self) -> float:
        return max(abs(self.displacement), _LEAST)


class ImpedanceProfile(NamedTuple):
    """All tests of one pair of things, in one pose."""

    tests: tuple[ImpedanceTest, ...]

    @property
    def is_whole(self) -> bool:
        """Whether every direction was tested both ways."""
        return len({(test.direction, test.sign) for test in self.tests}) == 2 * len(DIRECTIONS)

    def tracked(self) -> dict[str, bool]:
        """By direction, whether its load was tracked one way or the other (Figure 7.13)."""
        return {name: any(test.tracked for test in self._of(name)) for name in DIRECTIONS}

    def impedances(self) -> dict[str, float]:
        """By direction, the larger impedance of both ways, N/m or N m/rad."""
        return {
            name: max((test.impedance for test in self._of(name)), default=math.nan)
            for name in DIRECTIONS
        }

    def normalized(self) -> dict[str, float]:
        """By direction, shares of the largest impedance of a force, and of a torque (Fig. 7.14)."""
        impedances = self.impedances()
        most = {
            word: max(value for name, value in impedances.items() if name.startswith(word))
            for word in KINDS.values()
        }
        return {name: value / (most[name[:2]] or 1.0) for name, value in impedances.items()}

    def features(self) -> dict[str, float]:
        """Mean impedance of each way, by direction and sign such as ``dPz-``."""
        return {
            f"{test.direction}{'+' if test.sign > 0 else '-'}": test.mean_impedance
            for test in sorted(self.tests, key=lambda each: (each.direction, -each.sign))
        }

    def _of(self, direction: str) -> list[ImpedanceTest]:
        return [test for test in self.tests if test.direction == direction]

    def as_data(self) -> list[dict[str, float | int | str | bool]]:
        """A row for each test, for JSON or YAML."""
        return [test._asdict() for test in self.tests]

    @classmethod
    def from_data(cls, rows: Sequence[Mapping[str, object]]) -> Self:
        """A profile that ``as_data`` wrote.

        Raises:
            ValueError: a row is none of a test; says which and why.
        """
        return cls(tuple(_read(place, row) for place, row in enumerate(rows)))


def _read(place: int, row: Mapping[str, object]) -> ImpedanceTest:
    unknown = set(row) ^ set(ImpedanceTest._fields)
    if unknown:
        raise ValueError(f"test {place}: missing or unknown: {', '.join(sorted(unknown))}")
    if row["direction"] not in DIRECTIONS:
        raise ValueError(f"test {place}: '{row['direction']}' is none of {', '.join(DIRECTIONS)}")
    if row["sign"] not in (1, -1):
        raise ValueError(f"test {place}: a sign is 1 or -1, not {row['sign']}")
    return ImpedanceTest(**row)  # type: ignore[arg-type]
