"""The page of results: rows of this version alone, enough episodes, exact intervals."""

from __future__ import annotations

import json
import runpy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from cbdsl.numeric.proportion import exact_interval
from cbdsl_reproduction.judges.row_digests import code_text
from tests.conftest import ROOT
from tests.test_docs import words
from tests.test_seeds import DERIVED

PAGE = runpy.run_path(str(ROOT / "docs" / "make_results.py"))
CAMPAIGNS = list(PAGE["_campaigns"]())


def result(campaign: Any, **changed: Any) -> Mapping[str, Any]:
    """Return a result of a campaign in which each outcome comes in half of the episodes."""
    setting = {
        "judge": campaign.judge.name,
        "command": f"cb judge {campaign.judge.name}",
        "commit": "abc",
        "backend": campaign.backend,
        "cameras": campaign.cameras,
        "episodes": campaign.episodes,
    }
    row_digests = PAGE["row_digests"]
    rows = [
        {
            "condition": condition.name,
            "outcome": outcome,
            "successes": 10,
            "n": 20,
            "interval": exact_interval(10, 20),
            "aim": "at least 90 %",
            "digests": row_digests(campaign.judge, condition, campaign.backend),
            **changed,
        }
        for condition in campaign.shown
        for outcome in condition.aims
    ]
    return {**setting, "rows": rows}


def named(judge: str) -> Any:
    return next(each for each in CAMPAIGNS if each.judge.name == judge)


def page_with(folder: Path, judge: str, **changed: Any) -> str:
    """Return the page of a folder with the result of one judge, some of whose values differ."""
    contents = json.dumps(result(named(judge), **changed))
    (folder / f"{judge}.json").write_text(contents, "utf-8")
    page: str = PAGE["page"](folder)
    return page


def test_results_page_is_up_to_date() -> None:
    """``python docs/make_results.py`` writes it again."""
    page = PAGE["page"]()
    assert page == (ROOT / "docs" / "results.md").read_text("utf-8")
    assert words(page) <= 2000


def test_results_page_has_at_most_60_rows() -> None:
    assert sum(len(campaign.rows) for campaign in CAMPAIGNS) <= 60


def test_rows_name_conditions_with_their_outcome() -> None:
    for campaign in CAMPAIGNS:
        scores = {score.name for score in campaign.judge.scores}
        for row in campaign.rows:
            conditions = campaign.conditions(row)
            assert conditions, row
            assert all(row["outcome"] in {*each.aims, *scores} for each in conditions), row
            # A sum over conditions of different aims would hide a miss.
            aims = {str(each.aims.get(row["outcome"])) for each in conditions}
            assert len(aims) == 1, row


def test_page_shows_the_rows_of_this_version(tmp_path: Path) -> None:
    page = page_with(tmp_path, "find_by_touch")
    assert "| objects found in the dark | 10 of 20 | [27.2, 72.8] % | 90 % |" in page


@pytest.mark.parametrize("kind", ["law", "perception", "world", "judge", "documents"])
def test_page_leaves_out_rows_with_a_stale_digest(tmp_path: Path, kind: str) -> None:
    campaign = named("find_by_touch")
    (condition,) = campaign.shown
    digests = PAGE["row_digests"](campaign.judge, condition, campaign.backend)
    page = page_with(tmp_path, "find_by_touch", digests={**digests, kind: "0" * 16})
    assert "objects found in the dark" not in page


@pytest.mark.parametrize("changed", [{"episodes": 19}, {"cameras": "rendered"}, {"digests": None}])
def test_page_leaves_out_rows_of_another_setting(tmp_path: Path, changed: dict[str, Any]) -> None:
    assert "objects found" not in page_with(tmp_path, "find_by_touch", **changed)


def test_page_leaves_out_a_sum_with_a_stale_part(tmp_path: Path) -> None:
    contents = dict(result(named("pick_and_place")))
    contents["rows"] = [row for row in contents["rows"] if row["condition"] != "cube"]
    (tmp_path / "pick_and_place.json").write_text(json.dumps(contents), "utf-8")
    page = PAGE["page"](tmp_path)
    assert "| ball on a pad" in page
    assert "| cube, cylinder and box on a pad" not in page


def test_kept_rows_are_shown_with_their_own_command(tmp_path: Path) -> None:
    run = {"command": "cb judge old", "commit": "def", "episodes": 20}
    assert "`cb judge old` (def)" in page_with(tmp_path, "find_by_touch", run=run)


def test_campaign_seeds_are_derived_judging_seeds() -> None:
    for campaign in CAMPAIGNS:
        seed = campaign._seed(campaign.shown)
        assert seed in DERIVED
        assert seed + campaign.episodes - 1 in DERIVED
        # Two of the 10,000 blocks coincide now and then.
        longer = (campaign._replace(episodes=campaign.episodes + more) for more in (1, 2, 3))
        assert {other._seed(campaign.shown) for other in longer} != {seed}


def test_measured_rows_have_20_episodes_and_exact_intervals() -> None:
    for campaign in CAMPAIGNS:
        valid = campaign.valid(ROOT / "results")
        for row in campaign.rows:
            parts = [
                part
                for condition in campaign.conditions(row)
                for part in valid.get(condition.name, [])
                if part["outcome"] == row["outcome"]
            ]
            for part in parts:
                if part.get("n"):
                    interval = exact_interval(part["successes"], part["n"])
                    assert part["interval"] == pytest.approx(interval, abs=1e-6), part
            if parts:
                assert sum(part.get("n", part.get("episodes", 0)) for part in parts) >= 20, row


def test_code_text_ignores_comments_and_docstrings_alone() -> None:
    code = 'def f(x):\n    """Return x."""\n    # Why.\n    return "# é" + x  # Because.\n'
    assert code_text(code) == 'def f(x):\nreturn "# é" + x'
    assert code_text(code.replace("Return x.", "Give x.\n\n    More.")) == code_text(code)
    assert code_text(code.replace("+ x", "+ 2 * x")) != code_text(code)
