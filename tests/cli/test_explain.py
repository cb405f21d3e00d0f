"""``cb explain``, and the page of documentation that it writes."""

from __future__ import annotations

import pytest

from cbdsl.diagnostics.catalogue import catalogue
from cbdsl.diagnostics.entry_text import page
from cbdsl.documents.kinds import entries
from tests.cli.test_main import cb


@pytest.mark.parametrize("code", catalogue())
def test_every_code_is_explained(
    code: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "explain", code.lower()) == 0
    printed = capsys.readouterr().out
    entry = catalogue()[code]
    assert printed.startswith(f"{code}: {entry.title}")
    if entry.bad is not None:
        shown = [line[5:] for line in printed.split("\n") if line.startswith(("    +", "     "))]
        assert shown == entry.good.expandtabs().splitlines()


def test_explain_all_as_markdown_prints_the_page_of_all_codes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "explain", "--all", "--markdown") == 0
    every = sorted(entries().values(), key=lambda entry: entry.code)
    assert capsys.readouterr().out == page(every) + "\n"


def test_page_has_a_section_for_every_code() -> None:
    text = page(catalogue().values())
    assert all(f"\n## {code}: {entry.title}" in text for code, entry in catalogue().items())


@pytest.mark.parametrize("words", [[], ["CB504", "--all"], ["CB999"]])
def test_explain_without_a_code_or_all_exits_with_2(
    words: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, "explain", *words) == 2


@pytest.mark.parametrize(("code", "near"), [("CB999", None), ("504", "CB504"), ("cb5044", "CB504")])
def test_unknown_code_proposes_one_with_a_similar_number(
    code: str,
    near: str | None,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, "explain", code) == 2
    told = capsys.readouterr().err
    assert f"did you mean '{near}'?" in told if near else "did you mean" not in told


def test_version_is_reported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "--version") == 0
    assert capsys.readouterr().out.startswith("cbdsl 0.")
