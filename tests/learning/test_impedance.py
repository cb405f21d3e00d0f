"""Impedance is a load over a displacement, and an axis is stiff that tracks it one way or both."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from cbdsl.learning.impedance import ImpedanceProfile, ImpedanceTest
from cbdsl.types.direction import DIRECTIONS


def profile(stiff: dict[str, float]) -> ImpedanceProfile:
    """Return all tests; ``stiff`` directions are tracked one way, with these displacements."""
    tests = []
    for name in DIRECTIONS:
        load = 2.0 if name[1] == "P" else 0.1
        tests += [
            ImpedanceTest(name, 1, stiff.get(name, 0.2), load, name in stiff, 0.0, load / 2),
            ImpedanceTest(name, -1, -0.2, -load / 10, False, 0.0, -load / 20),
        ]
    return ImpedanceProfile(tuple(tests))


def test_axis_is_tracked_where_one_way_is() -> None:
    tracked = profile({"dPz": 0.002, "dRx": 0.01}).tracked()
    assert [name for name, each in tracked.items() if each] == ["dPz", "dRx"]


def test_impedance_is_the_load_over_the_displacement() -> None:
    impedances = profile({"dPz": 0.002}).impedances()
    assert impedances["dPz"] == pytest.approx(1000.0)
    assert impedances["dPx"] == pytest.approx(10.0)
    # A direction that does not move at all is as stiff as one that moves by a millimetre.
    assert ImpedanceTest("dPz", 1, 0.0, 2.0, tracked=True).impedance == pytest.approx(2000.0)


def test_forces_and_torques_have_scales_of_their_own() -> None:
    shares = profile({"dPz": 0.002, "dRx": 0.01}).normalized()
    assert shares["dPz"] == shares["dRx"] == 1.0
    assert shares["dPx"] == pytest.approx(0.01) and shares["dRy"] == pytest.approx(0.05)


def test_profile_without_a_test_is_not_whole() -> None:
    whole = profile({})
    assert whole.is_whole
    assert not ImpedanceProfile(whole.tests[1:]).is_whole
    assert math.isnan(ImpedanceProfile(()).impedances()["dPx"])


def test_profile_is_written_and_read() -> None:
    before = profile({"dPz": 0.002})
    assert ImpedanceProfile.from_data(json.loads(json.dumps(before.as_data()))) == before


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"direction": "dPw"}, "'dPw' is none of dPx"),
        ({"sign": 2}, "a sign is 1 or -1, not 2"),
        ({"lode": 1.0}, "missing or unknown: lode"),
    ],
)
def test_row_that_is_no_test_says_why(change: dict[str, Any], why: str) -> None:
    rows = profile({}).as_data()
    rows[3] = {**rows[3], **change}
    with pytest.raises(ValueError, match=f"test 3: {why}"):
        ImpedanceProfile.from_data(rows)


def test_features_are_the_mean_impedances_of_each_way_in_order() -> None:
    features = profile({"dPz": 0.002}).features()
    assert list(features)[:4] == ["dPx+", "dPx-", "dPy+", "dPy-"]
    assert features["dPz+"] == pytest.approx(500.0)
    assert features["dPz-"] == pytest.approx(0.5)
    assert features["dRy-"] == pytest.approx(0.025)


def test_shares_of_no_load_at_all_are_none() -> None:
    silent = ImpedanceProfile(tuple(each._replace(load=0.0) for each in profile({}).tests))
    assert set(silent.normalized().values()) == {0.0}
