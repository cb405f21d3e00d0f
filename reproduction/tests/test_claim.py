"""Claims: every one has a place in the source, a rule, and rows of pages that measure it."""

from __future__ import annotations

import re

import pytest

from cbdsl_reproduction.claim import Claim, VerdictRule
from cbdsl_reproduction.experiment import Experiment
from cbdsl_reproduction.pages import existing_pages, page_of
from cbdsl_reproduction.region import above, near
from cbdsl_reproduction.registry import EXPERIMENTS
from cbdsl_reproduction.summary import PageRow, rows_of
from tests.conftest import ROOT

EVERY = [pytest.param(each, id=each.name) for each in EXPERIMENTS.values()]
PAGES = existing_pages(ROOT / "docs" / "reproduction", EXPERIMENTS.values())


def rows(experiment: Experiment) -> list[PageRow]:
    """Return all rows of an experiment on its page, on any backend."""
    sections = re.split(r"\n(?=## )", PAGES[page_of(experiment)])
    every = [row for section in sections for row in rows_of(section)]
    return [row for row in every if row.section.split()[0] == experiment.name]


def plain(cell: str) -> str:
    return re.sub(r"\\([|*])", r"\1", cell)


def claims_of(experiment: Experiment, row: PageRow) -> list[Claim]:
    return [each for each in experiment.claims() if each.describes(plain(row.quantity))]


#: Claims that are younger than the pages, whose runs take hours; ``docs/deviations.md`` has the
#: numbers of a smaller run.
UNMEASURED = {
    "fig-5.8": ["normalised reward over all episodes, staged minus concurrent, exploring for 25"]
}


@pytest.mark.parametrize("experiment", EVERY)
def test_claim_has_a_place_in_the_source_and_a_rule(experiment: Experiment) -> None:
    assert experiment.claims()
    assert any(claim.rule is not VerdictRule.NONE for claim in experiment.claims())
    for claim in experiment.claims():
        assert re.match(r"Sections? \d", claim.place), claim
        assert claim.name and claim.rule in VerdictRule, claim
        # A region alone can be the report, as in ``rewarded at once``.
        assert claim.rule in (VerdictRule.NONE, VerdictRule.REGION) or claim.report, claim
        assert (claim.rule is VerdictRule.NONE) == (
            claim.region is claim.bound is claim.trials is None
        ), claim
        assert claim.ordering is None or claim.rule in (VerdictRule.REGION, VerdictRule.BOUND), (
            claim
        )


@pytest.mark.parametrize("experiment", EVERY)
def test_every_claim_has_a_measured_row_on_the_pages(experiment: Experiment) -> None:
    measured = [plain(row.quantity) for row in rows(experiment)]
    missing = [
        claim.name
        for claim in experiment.claims()
        if not any(claim.describes(name) for name in measured)
    ]
    assert missing == UNMEASURED.get(experiment.name, [])


@pytest.mark.parametrize("experiment", EVERY)
def test_every_row_on_the_pages_has_the_words_and_the_region_of_one_claim(
    experiment: Experiment,
) -> None:
    for row in rows(experiment):
        (claim,) = claims_of(experiment, row)
        assert Claim("", claim.report).describes(plain(row.source)), row
        if claim.rule is VerdictRule.REGION:
            assert claim.region is not None and plain(row.expected) == claim.region.text, row
        if claim.rule is VerdictRule.NONE:
            assert row.expected == "" and row.verdict == "not judged", row


def test_claim_with_a_measured_bound_has_a_region_afterwards() -> None:
    claim = Claim("Section 1", "{law}: rise", report="rises less under {law}", bound=above)
    assert claim.rule is VerdictRule.BOUND and claim.region is None
    measured = claim.named(law="c1").at(2.0)
    assert (measured.name, measured.report) == ("c1: rise", "rises less under c1")
    assert measured.region == above(2.0) and measured.rule is VerdictRule.BOUND
    with pytest.raises(AssertionError, match="no measured bound"):
        Claim("Section 1", "rise").at(1.0)


@pytest.mark.parametrize(
    ("name", "described"),
    [("a, 96 cm", True), ("a, cm", False), ("b, a, 96 cm", False)],
)
def test_words_in_braces_stand_for_any_text(name: str, described: bool) -> None:
    assert Claim("", "a, {depth} cm").describes(name) == described


@pytest.mark.parametrize(
    ("claim", "rule"),
    [
        (Claim("", ""), VerdictRule.NONE),
        (Claim("", "", region=near(1, 0.1)), VerdictRule.REGION),
        (Claim("", "", region=near(1, 0.1), bound=above), VerdictRule.BOUND),
        (Claim("", "", trials=(2, 5)), VerdictRule.TRIALS),
    ],
)
def test_rule_follows_from_the_record(claim: Claim, rule: VerdictRule) -> None:
    assert claim.rule is rule
