"""Judges: aims, conditions that exist, and verdicts by the truth of the world."""

from __future__ import annotations

from typing import Any

import pytest

import cbdsl
from cbdsl.api.documents import ProgramDocument
from cbdsl.api.shipped import shipped_document
from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.library import Library
from cbdsl_reproduction.judges.claim_judges import CLAIM_OF, CLAIMS, Placed, ProgramClaim
from cbdsl_reproduction.judges.claims import contexts_of
from cbdsl_reproduction.judges.insertion import widened
from cbdsl_reproduction.judges.judge import ANY, NONE, Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.judging import Campaign
from cbdsl_reproduction.judges.registry import JUDGES
from cbdsl_reproduction.judges.result import result_of
from tests.conftest import ROOT

#: Judge, condition and outcome of each aim.
AIMS = [
    pytest.param(judge, condition, outcome, id=f"{judge.name}-{condition.name}-{outcome}")
    for judge in JUDGES.values()
    for condition in judge.conditions
    for outcome in condition.aims
]
#: Conditions with documents of their own.
CONDITIONS = [
    pytest.param(condition, id=f"{judge.name}-{condition.name}")
    for judge in JUDGES.values()
    for condition in judge.conditions
    # Those of stacks name contexts of two stages; values of claims depend on the context.
    if judge.name not in ("stacks", "claims") and condition.program
]


def campaign_of(judge: Judge, condition: JudgedCondition, episodes: int) -> Campaign:
    return Campaign(judge, (condition,), judge.body, 0, episodes)


def verdicts_with(condition: JudgedCondition, outcome: str, amiss: int) -> list[EpisodeVerdict]:
    """Return a hundred verdicts, all of them as aimed but for one outcome of some."""
    good = {name: aim.is_least for name, aim in condition.aims.items()}
    bad = good | {outcome: not good[outcome]}
    scored = {"brier": 0.1, "base_rate_brier": 0.2}
    return [
        EpisodeVerdict(seed, bad if seed < amiss else good, 1.0, "", scored) for seed in range(100)
    ]


@pytest.mark.parametrize(("judge", "condition", "outcome"), AIMS)
def test_result_is_missed_just_beyond_each_aim(
    judge: Judge, condition: JudgedCondition, outcome: str
) -> None:
    aim = condition.aims[outcome]
    allowed = 100 if aim == ANY else round(100 * (1 - aim.least if aim.is_least else aim.most))
    for amiss in {allowed, min(allowed + 1, 100)}:
        verdicts = {condition.name: verdicts_with(condition, outcome, amiss)}
        result = result_of(campaign_of(judge, condition, 100), verdicts)
        assert result["met"] == (amiss <= allowed)


@pytest.mark.parametrize(
    ("judge", "condition", "outcome", "amiss", "met"),
    [
        ("scenes", "in view", "right", 2, True),
        ("scenes", "in view", "right", 3, False),
        ("scenes", "in view", "ghost", 1, False),
        ("force", "right hand", "within tolerance", 5, True),
        ("force", "right hand", "within tolerance", 6, False),
        ("calibration", "calibrated", "rewarded", 2, True),
        ("calibration", "calibrated", "rewarded", 3, False),
        ("calibration", "calibrated", "rewarded without contact", 1, False),
    ],
)
def test_result_of_100_misses_the_stated_aim(
    judge: str, condition: str, outcome: str, amiss: int, met: bool
) -> None:
    (judged,) = (each for each in JUDGES[judge].conditions if each.name == condition)
    verdicts = {condition: verdicts_with(judged, outcome, amiss)}
    assert result_of(campaign_of(JUDGES[judge], judged, 100), verdicts)["met"] == met


@pytest.mark.parametrize("condition", CONDITIONS)
def test_condition_names_documents_that_fit(condition: JudgedCondition) -> None:
    request = cbdsl.load(condition.program, stage=condition.stage, values=condition.values)
    if condition.context is not None:
        assert condition.context in request.stage.contexts


@pytest.mark.parametrize("claim", CLAIMS, ids=[claim.program for claim in CLAIMS])
def test_claim_names_documents_that_fit(claim: ProgramClaim) -> None:
    contexts = contexts_of(claim)
    assert contexts
    by_values = {tuple(sorted(claim.values(context).items())): context for context in contexts}
    for values in by_values:
        request = cbdsl.load(claim.program, stage=claim.stage, values=dict(values))
        assert set(contexts) <= set(request.stage.contexts)


@pytest.mark.parametrize(
    ("claim", "programs", "controller"),
    [
        ("deliver", ["deliver"], "there"),
        ("bring", ["bring"], "there"),
        ("bring_from_side", ["bring_from_side"], "there"),
        ("bring_pinched", ["bring_pinched"], "there"),
        ("bring_with_both", ["bring_with_both"], "there"),
        ("fetch", ["bring", "bring_from_side", "bring_pinched", "bring_with_both"], "there"),
        ("pick_and_place", ["pick_and_place"], "near"),
    ],
)
def test_judge_of_a_placed_object_accepts_no_more_than_the_program(
    claim: str, programs: list[str], controller: str
) -> None:
    documents = [shipped_document(ProgramDocument, name) for name in programs]
    sections = [document.controllers[controller] for document in documents]
    tolerances = [float(section.quiescence.tolerance or 0) for section in sections]  # type: ignore[union-attr]
    judge = CLAIM_OF[claim].judge
    assert isinstance(judge, Placed)
    assert judge.within <= max(tolerances)


def test_result_without_counted_episodes_misses_its_aim() -> None:
    condition = JUDGES["placing"].conditions[0]
    verdicts = [EpisodeVerdict(seed, dict.fromkeys(condition.aims), 1.0, "") for seed in range(3)]
    campaign = campaign_of(JUDGES["placing"], condition, 3)
    result = result_of(campaign, {condition.name: verdicts})
    assert {row["n"] for row in result["rows"]} == {0}
    assert not result["met"]


@pytest.mark.parametrize(
    ("aim", "text"),
    [
        (ANY, ""), (NONE, "none"), (Aim(0.97), "at least 97 %"), (Aim(most=0.02), "at most 2 %"),
    ],
)  # fmt: skip
def test_aim_is_shown_in_percent(aim: Aim, text: str) -> None:
    assert str(aim) == text


@pytest.mark.parametrize("workers", [1, 2])
def test_campaign_finds_the_outcomes_of_single_episodes(workers: int) -> None:
    judge = JUDGES["success_rates"]
    conditions = tuple(each for each in judge.conditions if each.name in ("right", "absent"))
    body = judge.body._replace(backend="kinematic")
    seen: list[tuple[int, int]] = []
    campaign = Campaign(judge, conditions, body, 7, 2)
    verdicts = campaign.run(workers, lambda done, of: seen.append((done, of)))
    assert seen[-1] == (4, 4)
    for condition in conditions:
        request = cbdsl.load(condition.program, stage=condition.stage, values=condition.values)
        results = [cbdsl.run(request, seed=seed, backend="kinematic")[0] for seed in campaign.seeds]
        own = verdicts[condition.name]
        assert [verdict.outcomes["rewarded"] for verdict in own] == [r.rewarded for r in results]
        assert [verdict.seconds for verdict in own] == [r.sim_seconds for r in results]
        assert [verdict.seed for verdict in own] == [7, 8]


class _World:
    """Truth in which some fingertips touch the balls."""

    def __init__(self, **touching: int) -> None:
        self._touching = touching
        self.objects = ("one", "other")

    def touching(self, name: str) -> frozenset[tuple[str, str]]:
        return frozenset(("hand", str(k)) for k in range(self._touching.get(name, 0)))


@pytest.mark.parametrize(
    ("worlds", "is_false"),
    [
        ([{"one": 3}, {"other": 3}], False),
        ([{"one": 3}, {"other": 2}], True),
        ([{"other": 3}], True),
        ([{"one": 3}, {"one": 3, "other": 3}], True),
    ],
)
def test_find_the_other_doubts_a_reward_without_contacts_in_turn(
    worlds: list[dict[str, int]], is_false: bool
) -> None:
    from cbdsl_reproduction.judges.find_the_other import _Turns

    watch: Any = _Turns.__new__(_Turns)
    watch.begin()
    for world in worlds:
        watch.truth = _World(**world)
        watch.note(None)
    result = cbdsl.EpisodeResult(
        "", "", "", 1, rewarded=True, predicates=(), actions=(), ticks=1, sim_seconds=1.0,
        wall_seconds=1.0, renderer="", ending="",
    )  # fmt: skip
    assert watch.conclude(result).outcomes["rewarded without contacts"] == is_false


def test_widened_holes_leave_the_clearance() -> None:
    library = Library(ROOT)
    pairs = library.read(library.locate(StageDocument, "pairs"), StageDocument).document
    for clearance, outer in ((0.01, 0.06), (0.02, 0.07)):
        tube, tray = (widened(pairs, clearance).things[name] for name in ("tube", "tray"))
        assert tube.form.radius == pytest.approx((outer, outer))
        assert tray.form.size == (*(pytest.approx((2 * outer,) * 2),) * 2, (0.1, 0.1))
    assert pairs.things["tube"].form.radius == (0.06, 0.06), "10 mm, as the stage has it"


@pytest.mark.parametrize(
    ("own", "met", "tie"),
    [(0.05, True, False), (0.25, False, True), (0.25 - 1e-12, False, True), (0.3, False, False)],
)
def test_score_is_missed_unless_its_mean_is_below_the_baseline(
    own: float, met: bool, tie: bool
) -> None:
    judge = JUDGES["catalogs"]
    condition = judge.conditions[0]
    outcomes = dict.fromkeys(condition.aims, True)
    measures = {"brier": own, "base_rate_brier": 0.25}
    verdicts = [EpisodeVerdict(seed, outcomes, 1.0, "", measures) for seed in range(9)]
    result = result_of(campaign_of(judge, condition, 9), {condition.name: verdicts})
    (row,) = (each for each in result["rows"] if each["outcome"] == "Brier score")
    assert row["met"] is met is result["met"]
    assert row["result"].endswith("(tie)") is tie
    assert row["interval"] == pytest.approx([own - 0.25] * 2, abs=1e-6)


def test_catalogs_are_all_judged() -> None:
    shipped = {path.stem for path in (ROOT / "knowledge" / "catalogs").glob("*.yaml")}
    assert {condition.name for condition in JUDGES["catalogs"].conditions} == shipped
