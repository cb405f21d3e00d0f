"""Pages, which count the verdicts of their rows and group the misses by their causes."""

from __future__ import annotations

import re

from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.pages import chapter_page, existing_pages, page_of, summary_page
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity, Verdict
from cbdsl_reproduction.region import above
from cbdsl_reproduction.registry import EXPERIMENTS
from cbdsl_reproduction.report import section
from cbdsl_reproduction.summary import PageRow, causes, causes_of, rows_of
from tests.conftest import ROOT

FOLDER = ROOT / "docs" / "reproduction"
ORDER = EXPERIMENTS.values()


def some(name: str, hits: int, trials: int) -> Quantity:
    return percentage(Claim("", name, "%", "most | all", above(50)), hits, trials, note="a | b")


def part(name: str, *quantities: Quantity) -> str:
    return section(EXPERIMENTS[name], RunSettings(), Result(quantities))


def committed_rows() -> list[PageRow]:
    pages = existing_pages(FOLDER, ORDER).values()
    parts = [part for page in pages for part in re.split(r"\n(?=## )", page)]
    return [row for part in parts for row in rows_of(part)]


def test_rows_of_a_section_are_the_rows_of_its_table() -> None:
    rows = list(rows_of(part("fig-4.5", some("X*, a → b", 30, 30), some("one", 1, 1))))
    assert [row.verdict for row in rows] == [Verdict.REPRODUCED, Verdict.NOT_JUDGED]
    assert {row.section for row in rows} == {"fig-4.5"}


def test_page_of_an_experiment_is_its_chapter() -> None:
    pages = {name: page_of(each) for name, each in EXPERIMENTS.items()}
    assert pages["law-as-printed"] == pages["fig-3.4"] == "chapter_3"
    assert pages["table-7.1-7.2"] == "chapter_7" and pages["engines"] == "engines"


def test_summary_counts_each_chapter_and_groups_misses_by_cause() -> None:
    printed = part("law-as-printed", some("printed law: it moves", 2, 30), some("ours: so", 30, 30))
    drawn = part("fig-4.5", some("share", 15, 30), some("one", 1, 1))
    pages = {
        "chapter_3": chapter_page("chapter_3", "", {"law-as-printed": printed}, ORDER),
        "chapter_4": chapter_page("chapter_4", "", {"fig-4.5": drawn}, ORDER),
    }
    text = summary_page(pages)
    assert "1 of 3 judged rows (33 %) are reproduced; 1 are not judged." in text
    assert "| [Chapter 3](chapter_3.md) | 1 | 0 | 0 | 1 | 0 |  |" in text
    assert "* law-as-printed (1 missed): the printed equations" in text
    assert "* fig-4.5 (1 undecided): too few trials for a verdict." in pages["chapter_4"]


def test_rows_of_one_cause_share_an_entry() -> None:
    text = part("fig-4.5", some("a", 15, 30), some("b", 14, 30), some("c", 30, 30))
    assert causes_of(list(rows_of(text))) == [
        "* fig-4.5 (2 undecided): too few trials for a verdict."
    ]


def test_chapter_page_keeps_other_sections_and_their_order() -> None:
    first = chapter_page("chapter_4", "", {"fig-4.7": part("fig-4.7", some("a", 1, 30))}, ORDER)
    new = {"fig-4.5": part("fig-4.5", some("share", 30, 30))}
    again = chapter_page("chapter_4", first, new, ORDER)
    assert again.index("## Not reproduced") < again.index("## fig-4.5") < again.index("## fig-4.7")
    assert "1 of 2 judged rows" in again
    assert chapter_page("chapter_4", again, new, ORDER) == again


def test_committed_pages_equal_regenerated_ones() -> None:
    pages = existing_pages(FOLDER, ORDER)
    assert all(chapter_page(name, text, {}, ORDER) == text for name, text in pages.items())
    assert summary_page(pages) == (FOLDER / "index.md").read_text("utf-8")


def test_summary_fits_a_screen() -> None:
    _, summary = (FOLDER / "index.md").read_text("utf-8").split("## Summary")
    assert len(summary.splitlines()) <= 60


def test_every_miss_on_the_pages_has_a_cause_and_every_cause_a_miss() -> None:
    rows = committed_rows()
    assert len(rows) > 500
    missed = [row for row in rows if row.verdict not in (Verdict.REPRODUCED, Verdict.NOT_JUDGED)]
    assert "cause not known" not in "".join(causes_of(rows))
    assert [each for each in causes() if not any(map(each.explains, missed))] == []
