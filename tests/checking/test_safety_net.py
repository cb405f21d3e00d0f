"""Checks that fail: a diagnostic of their document, in every format, and complete other ones."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from cbdsl.api.check import check
from cbdsl.cli.validation import FORMATS
from cbdsl.diagnostics.diagnostic import FAILED_CHECK
from cbdsl.documents.kinds import KINDS
from cbdsl.editor.buffers import Buffers
from cbdsl.yaml_text.library import shipped
from tests.cli.test_main import BAD, cb
from tests.diagnostics.test_sarif_format import faults

SOUND = shipped() / "knowledge" / "policies" / "reachtouch.yaml"
FAULTY = BAD / "programs" / "type_clash.yaml"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with a document whose check fails between two others."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CB_TRACEBACK", raising=False)
    shutil.copy(FAULTY, "a_type_clash.yaml")
    shutil.copy(SOUND, "b_reachtouch.yaml")
    shutil.copy(FAULTY, "c_type_clash.yaml")

    def fail(*_: object) -> None:
        raise RecursionError("maximum recursion depth exceeded")

    module, _, function = KINDS.get("policy").checker.partition(":")
    monkeypatch.setattr(f"{module}.{function}", fail)
    return tmp_path


def codes(log: Any) -> dict[str, set[str]]:
    """Return the codes of a SARIF log's results by file."""
    found: dict[str, set[str]] = {}
    for result in log["runs"][0]["results"]:
        place = result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
        found.setdefault(place, set()).add(result["ruleId"])
    return found


@pytest.mark.parametrize("form", FORMATS)
def test_validate_with_a_failing_check_reports_it_beside_the_other_documents(
    form: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "validate", "--format", form, ".") == 2
    told = capsys.readouterr().out
    assert "b_reachtouch.yaml" in told and FAILED_CHECK in told and "RecursionError" in told
    assert "a_type_clash.yaml" in told and "c_type_clash.yaml" in told


def test_sarif_with_a_failing_check_is_valid_and_complete(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cb(monkeypatch, "validate", "--format", "sarif", "a_type_clash.yaml", "c_type_clash.yaml")
    alone = json.loads(capsys.readouterr().out)
    cb(monkeypatch, "validate", "--format", "sarif", ".")
    log = json.loads(capsys.readouterr().out)
    assert faults(log) == []
    assert codes(log) == {**codes(alone), "b_reachtouch.yaml": {FAILED_CHECK}}
    assert [each["runs"][0]["invocations"][0]["executionSuccessful"] for each in (alone, log)] == [
        True,
        False,
    ]


def test_validate_with_traceback_wanted_raises_the_failure(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CB_TRACEBACK", "1")
    with pytest.raises(RecursionError):
        cb(monkeypatch, "validate", ".")


def test_editor_and_interface_with_a_failing_check_report_it(here: Path) -> None:
    (found,) = Buffers(here).diagnostics(here / "b_reachtouch.yaml")
    assert found.code == FAILED_CHECK
    assert {diagnostic.code for diagnostic in check("b_reachtouch.yaml")} == {FAILED_CHECK}
