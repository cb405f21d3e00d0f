"""Worth of choices, estimated from transitions, in cases computed by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from drawn_experience import experience

from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.experience import Experience
from cbdsl.training.trial import Trial
from cbdsl_reproduction.chapter_4.worth import met, shares_of, worth_claims, worth_quantities
from cbdsl_reproduction.series import REACHTOUCH, SEQUENTIAL
from tests.conftest import Checked
from tests.training.toy import toy_trial


def trial_of(trial: Trial, *experiences: Experience) -> Trial:
    for each in experiences:
        trial.replay(each)
    return trial


def worth(trial: Trial, gamma: float = 0.8) -> dict[tuple[str, str], float]:
    found = met([trial])
    return dict(zip(found.pairs, found.worth(gamma).tolist(), strict=True))


DIRECT = experience(("XX", "track", "X0"), ("X0", "track", "X1"), reward=1)
DETOUR = experience(("XX", "search", "0X"), ("0X", "track", "X0"), ("X0", "track", "X1"), reward=1)
NOTHING = experience(("XX", "track", "X-"), ("X-", "track", "X-"))


def test_worth_averages_discounted_continuations_by_frequency() -> None:
    found = worth(trial_of(toy_trial(), *[DIRECT, DETOUR, DETOUR, NOTHING] * 5))
    assert found["X0", "track"] == pytest.approx(1.0)
    assert found["0X", "track"] == pytest.approx(0.8)
    assert found["XX", "search"] == pytest.approx(0.64)
    assert found["XX", "track"] == pytest.approx(0.5 * 0.8)
    assert found["X-", "track"] == 0.0


def test_choice_is_valued_with_the_best_continuation() -> None:
    badly = experience(("0X", "search", "X-"))
    found = worth(trial_of(toy_trial(), *[DETOUR, badly, badly, badly] * 5))
    assert found["XX", "search"] == pytest.approx(0.64)


def test_worth_of_a_rarely_met_pair_is_undefined() -> None:
    found = worth(trial_of(toy_trial(), *[DIRECT] * 9, *[DETOUR] * 4))
    assert math.isnan(found["XX", "search"])
    assert found["XX", "track"] == pytest.approx(0.8)


def test_used_program_is_one_choice(checked: Checked) -> None:
    looked = experience(
        ("XXX", "searchtrack", "0XX"),
        ("0XX", "searchtrack", "1XX"),
        ("1XX", "reach ◁ touch", "X11"),
        reward=1,
    )
    trial = Trial(checked("reachtouch"), AccommodateConstants(), 1)
    found = worth(trial_of(trial, *[looked] * 5))
    assert found["XXX", "searchtrack"] == pytest.approx(0.8)
    assert ("0XX", "searchtrack") not in found


def test_trial_counts_once_per_occurrence_in_the_sample() -> None:
    found = met([trial_of(toy_trial(), *[DIRECT] * 6), trial_of(toy_trial(), *[NOTHING] * 6)])
    place = found.pairs.index(("XX", "track"))
    for times, expected in ((1, 1), 0.4), ((2, 0), 0.8), ((0, 2), 0.0), ((3, 1), 0.6):
        assert found.worth(0.8, np.array(times))[place] == pytest.approx(expected)


def test_quantity_is_a_share_of_the_best_choice() -> None:
    trials = [trial_of(toy_trial(), *[DIRECT, DETOUR] * 6) for _ in range(5)]
    choices = [("XX", "search"), ("XX", "track"), ("1X", "track")]
    detour, direct, never = worth_quantities(worth_claims("", SEQUENTIAL, choices), trials, seed=0)
    assert detour.ours == pytest.approx(80) and detour.verdict == "missed"
    assert direct.ours == pytest.approx(100) and direct.verdict == "reproduced"
    assert direct.note == "others: search 80"
    assert direct.interval == pytest.approx((100, 100))
    assert math.isnan(never.ours) and never.interval is None and never.note == ""


def test_shares_are_reported_of_every_state() -> None:
    shares = shares_of([trial_of(toy_trial(), *[DIRECT, DETOUR] * 6) for _ in range(5)])
    assert shares["XX"] == pytest.approx({"track": 100, "search": 80})
    assert shares["X0"] == {}, "there is nothing to compare with"


def test_few_trials_give_no_verdict() -> None:
    few = [trial_of(toy_trial(), *[DIRECT, DETOUR] * 6) for _ in range(4)]
    claims = worth_claims("", REACHTOUCH, [("XX", "track")])
    assert not list(worth_quantities(claims, few, seed=0))
    assert shares_of(few) == {}


@pytest.mark.parametrize("met_by_all", [(DIRECT,), (NOTHING, NOTHING)])
def test_pair_without_an_alternative_has_no_claim(
    met_by_all: tuple[Experience, ...],
) -> None:
    trials = [trial_of(toy_trial(), *met_by_all * 6) for _ in range(5)]
    (found,) = worth_quantities(worth_claims("", SEQUENTIAL, [("XX", "track")]), trials, seed=0)
    assert math.isnan(found.ours) and found.interval is None and found.note == ""
