"""The summary, which counts the verdicts of the page's rows and gives each miss its cause."""

from __future__ import annotations

from cbdsl_reproduction.claim import above
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity, Verdict
from cbdsl_reproduction.registry import EXPERIMENTS
from cbdsl_reproduction.report import page, section
from cbdsl_reproduction.summary import causes, rows_of, summary
from tests.conftest import ROOT


def some(name: str, hits: int, trials: int) -> Quantity:
    return percentage(name, "most | all", hits, trials, above(50), note="a | b")


def part(name: str, *quantities: Quantity) -> str:
    return section(EXPERIMENTS[name], RunSettings(), Result(quantities), "page")


def test_rows_are_read_from_a_section() -> None:
    rows = list(rows_of(part("fig-4.5", some("X*, a → b", 30, 30), some("one", 1, 1))))
    assert [row.verdict for row in rows] == [Verdict.REPRODUCED, Verdict.NOT_JUDGED]
    assert {row.section for row in rows} == {"fig-4.5"}


def test_verdicts_are_counted_and_misses_have_causes() -> None:
    parts = [
        part("law-as-printed", some("printed law: it moves", 2, 30), some("ours: so", 30, 30)),
        part("fig-4.5", some("share", 15, 30), some("one", 1, 1)),
    ]
    text = summary(parts)
    assert "1 of 3 judged rows are reproduced (33 %); 1 are not judged." in text
    assert "| law-as-printed | 1 | 0 | 0 | 1 | 0 |" in text
    assert "missed; the printed equations" in text
    assert "fig-4.5, share: 50 [31.3, 68.7] %, undecided; too few trials for a verdict." in text


def test_the_page_begins_with_its_summary_once() -> None:
    first = page("", {"fig-4.5": part("fig-4.5", some("share", 30, 30))}, EXPERIMENTS)
    again = page(first, {"fig-4.7": part("fig-4.7", some("share", 1, 30))}, EXPERIMENTS)
    assert again.count("## Summary") == 1
    assert again.index("## Summary") < again.index("## fig-4.5") < again.index("## fig-4.7")
    assert "1 of 2 judged rows" in again


def test_every_miss_on_the_page_has_a_cause_and_every_cause_a_miss() -> None:
    text = (ROOT / "docs" / "reproduction.md").read_text(encoding="utf-8")
    assert "cause not known" not in text
    rows = [row for part in text.split("\n## ")[1:] for row in rows_of(f"## {part}")]
    missed = [row for row in rows if row.verdict not in (Verdict.REPRODUCED, Verdict.NOT_JUDGED)]
    assert [each for each in causes() if not any(map(each.explains, missed))] == []
