"""Impedance of a pair of objects, from tests along and about axes (Section 7.2).

A test moves or turns the held object along or about an axis of the world frame. It ends when a load
of a given size is tracked or at the end of its range. Impedance is the load over the displacement
(Eq 7.10). An axis is stiff if the load was tracked in either direction.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Self

from cbdsl.types.direction import DIRECTIONS, KINDS

# Smallest displacement, m or rad, which bounds the measurable stiffness.
_LEAST = 1e-3


class ImpedanceTest(NamedTuple):
    """Test in one direction along or about an axis of the world frame.

    Attributes:
        direction: One of ``DIRECTIONS``.
        sign: Sign of the motion, 1 or -1.
        displacement: Signed displacement of the tip that carries the hand, m or rad.
        load: Signed change of the load that the hand exerts, N or N m (about the tip).
        tracked: True if the requested load was reached and kept.
        residue: Distance of the tip from its start after its return, m or rad.
        resistance: Signed mean over the way of the load that the hand exerts in excess of the load
            with the held object unsupported, N or N m.
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
        """Magnitude of the load over that of the displacement, N/m or N m/rad (Eq 7.10)."""
        return abs(self.load) / self._way

    @property
    def mean_impedance(self) -> float:
        """Magnitude of the resistance over that of the displacement, N/m or N m/rad.

        Friction acts from the beginning of the motion, and at its end a grip may have slipped.
        """
        return abs(self.resistance) / self._way

    @property
    def _way(self) -> float:
        return max(abs(self.displacement), _LEAST)


class ImpedanceProfile(NamedTuple):
    """All tests of one pair of objects, in one pose."""

    tests: tuple[ImpedanceTest, ...]

    @property
    def is_whole(self) -> bool:
        """Whether every direction was tested both ways."""
        return len({(test.direction, test.sign) for test in self.tests}) == 2 * len(DIRECTIONS)

    def tracked(self) -> dict[str, bool]:
        """Return by direction whether its load was tracked in either sense (Figure 7.13)."""
        return {name: any(test.tracked for test in self._of(name)) for name in DIRECTIONS}

    def impedances(self) -> dict[str, float]:
        """Return by direction the larger impedance of both senses, N/m or N m/rad."""
        return {
            name: max((test.impedance for test in self._of(name)), default=math.nan)
            for name in DIRECTIONS
        }

    def normalized(self) -> dict[str, float]:
        """Return by direction the share of the largest force or torque impedance (Fig. 7.14)."""
        impedances = self.impedances()
        most = {
            word: max(value for name, value in impedances.items() if name.startswith(word))
            for word in KINDS.values()
        }
        # In free motion, for example, all impedances of a kind are 0, and so are their shares.
        return {name: value / (most[name[:2]] or 1.0) for name, value in impedances.items()}

    def features(self) -> dict[str, float]:
        """Return the mean impedance of each test, by direction and sign such as ``dPz-``."""
        return {
            f"{test.direction}{'+' if test.sign > 0 else '-'}": test.mean_impedance
            for test in sorted(self.tests, key=lambda each: (each.direction, -each.sign))
        }

    def _of(self, direction: str) -> list[ImpedanceTest]:
        return [test for test in self.tests if test.direction == direction]

    def as_data(self) -> list[dict[str, float | int | str | bool]]:
        """Return a row for each test, for JSON or YAML."""
        return [test._asdict() for test in self.tests]

    @classmethod
    def from_data(cls, rows: Sequence[Mapping[str, object]]) -> Self:
        """Return a profile from rows that ``as_data`` wrote.

        Raises:
            ValueError: If a row is not a valid test; the message names the row and the reason.
        """
        return cls(tuple(_read(place, row) for place, row in enumerate(rows)))


#: Profile of an episode without tests.
UNTESTED = ImpedanceProfile(())


def _read(place: int, row: Mapping[str, object]) -> ImpedanceTest:
    unknown = set(row) ^ set(ImpedanceTest._fields)
    if unknown:
        raise ValueError(f"test {place}: missing or unknown: {', '.join(sorted(unknown))}")
    if row["direction"] not in DIRECTIONS:
        raise ValueError(f"test {place}: '{row['direction']}' is none of {', '.join(DIRECTIONS)}")
    if row["sign"] not in (1, -1):
        raise ValueError(f"test {place}: a sign is 1 or -1, not {row['sign']}")
    return ImpedanceTest(**row)  # type: ignore[arg-type]
