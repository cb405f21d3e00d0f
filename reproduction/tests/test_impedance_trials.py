"""Hand loads of a cylinder in a tube, and of a ball on a ball, with physics."""

from __future__ import annotations

import pytest

from cbdsl_reproduction.impedance_trials import ImpedanceTrial, run_trials
from cbdsl_reproduction.thing_pairs import PAIRS

pytestmark = pytest.mark.slow


def trial(name: str) -> ImpedanceTrial:
    pytest.importorskip("mujoco")
    (found,) = run_trials(name, [9_100_000], "mujoco", "ideal")
    return found


def signs(found: ImpedanceTrial) -> list[bool]:
    pair, tracked = PAIRS[found.things], found.profile.tracked()
    return pair.right(tracked)


@pytest.mark.parametrize("name", ["cylinder_in_cylinder", "football_on_ball"])
def test_directions_are_stiff_as_in_the_source(name: str) -> None:
    found = trial(name)
    assert found.profile.is_whole
    assert len(signs(found)) == 6 and all(signs(found))


def test_displacements_are_bounded_and_the_pose_is_restored() -> None:
    tests = trial("cylinder_in_cylinder").profile.tests
    assert len(tests) == 12
    for test in tests:
        turns = test.direction[1] == "R"
        assert abs(test.displacement) < (0.45 if turns else 0.025)
        assert test.residue < (0.01 if turns else 0.001)
        # A wall is met after its clearance of 1 cm, not before.
        if test.direction in ("dPx", "dPy"):
            assert 0.005 < abs(test.displacement) < 0.015
            assert test.displacement * test.sign > 0.0
    loads = [abs(test.load) for test in tests if test.tracked and test.direction[1] == "P"]
    assert loads and all(1.5 < load < 2.5 for load in loads)


def test_resistance_counts_from_before_the_object_was_borne() -> None:
    """Press a hand on a ball before it goes down: it bears more than the added load."""
    tests = {(each.direction, each.sign): each for each in trial("football_on_ball").profile.tests}
    down = tests["dPz", -1]
    assert down.tracked and 1.5 < -down.load < 3.5
    assert -down.load < -down.resistance < 8.0
    # Nothing bears a ball on its way up; its weight is not counted.
    assert abs(tests["dPz", 1].resistance) < 0.5
