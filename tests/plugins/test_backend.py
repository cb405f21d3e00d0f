"""A backend of another package: found by its name, listed, and run on."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cbdsl.backends.backend import BACKENDS
from tests.cli.test_main import cb
from tests.plugins.generic import run_generic
from tests.plugins.installed import write_package


def test_programs_run_on_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, "run", "posture", "--backend", "ideal") == 0
    assert "Done after" in capsys.readouterr().out


def test_it_is_listed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert cb(monkeypatch, "show", "backends", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    summary = "Joints without errors; see ``cbdsl.backends.backend.Backend``."
    assert shown[-1] == {"backend": "ideal", "package": "demo 1.0", "summary": summary}
    assert [each["backend"] for each in shown[:-1]] == list(BACKENDS.builtins)


@pytest.mark.parametrize("tests", ["backends/test_contract.py", "backends/test_limits.py"])
def test_it_enters_the_generic_tests(tests: str, site: Path) -> None:
    run_generic(tests, "ideal", site)


def test_a_broken_one_is_named_with_its_package_and_takes_nothing_down(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_package(folder, "odd", {BACKENDS.group: {"odd": "builtins:dict"}})
    BACKENDS.refresh()
    assert cb(monkeypatch, "show", "backends") == 0
    out, err = capsys.readouterr()
    assert "ideal" in out and "odd" not in out
    assert "backend 'odd' (package odd 1.0, group cbdsl.backends): lacks the methods reset" in err
