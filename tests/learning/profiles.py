"""Impedance profiles for tests."""

from __future__ import annotations

from cbdsl.learning.impedance import ImpedanceProfile, ImpedanceTest
from cbdsl.types.direction import DIRECTIONS


def profile(**loads: float) -> ImpedanceProfile:
    """Return a complete profile over ways of 1 cm or 10 mrad; other loads are 0.01 N or N m."""
    given = {name: loads.get(name, 0.01) for name in DIRECTIONS}
    return ImpedanceProfile(
        tuple(
            ImpedanceTest(name, sign, 0.01 * sign, load, load > 1.0, 0.0, load)
            for name, load in given.items()
            for sign in (1, -1)
        )
    )


ROUND, FLAT = profile(dPz=40.0, dRz=1e-4), profile(dPz=40.0, dRz=2e-3)
