"""A learner of another package: chosen, run, resumed, recorded and listed like ACCOMMODATE."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cbdsl.documents.policy import PolicyDocument
from cbdsl.learning.learner import LEARNERS
from cbdsl.yaml_text.reader import read
from docs.make_reference import page
from tests.cli.test_main import cb
from tests.plugins.installed import write_package

LEARN = ("learn", "searchtrack", "--backend", "kinematic", "--seed", "3")
MONTE_CARLO = (*LEARN, "--learner", "monte_carlo", "--set", "exploration=0.5", "--gamma", "0.70")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_plugin_learner_resumes_with_the_same_result(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, *MONTE_CARLO, "--episodes", "4", "--out", "whole/p.yaml") == 0
    assert cb(monkeypatch, *MONTE_CARLO, "--episodes", "2", "--out", "parts/p.yaml") == 0
    longer = ("--episodes", "4", "--resume", "--out", "parts/p.yaml")
    assert cb(monkeypatch, *MONTE_CARLO, *longer) == 0
    assert (here / "whole/p.yaml").read_bytes() == (here / "parts/p.yaml").read_bytes()
    assert cb(monkeypatch, "validate", "whole/p.yaml") == 0
    found = read(here / "whole" / "p.yaml", PolicyDocument).document
    provenance = found.provenance
    assert found.values and provenance is not None and provenance.algorithm == "monte_carlo"
    assert provenance.constants.items() >= {"exploration": 0.5, "gamma": 0.7}.items()
    assert provenance.versions["demo"] == "1.0"
    words = "--learner monte_carlo --gamma 0.7 --set exploration=0.5"
    assert words in provenance.command


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--set", "exploraton=0.5"), "did you mean 'exploration'"),
        (("--set", "exploration=2"), "constant exploration = 2: "),
        (("--set", "patience=3 cm"), "constant patience = 3 cm: "),
        (("--bandwidth", "0.1"), "unknown constant of learner 'monte_carlo', 'bandwidth'"),
        (("--set", "exploration"), "--set exploration: expected name=value"),
    ],
)
def test_wrong_constants_are_reported(
    words: tuple[str, ...],
    said: str,
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, *LEARN, "--learner", "monte_carlo", *words, "--out", "p.yaml") == 2
    assert said in capsys.readouterr().err


def test_resume_with_another_learner_is_refused(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *MONTE_CARLO, "--episodes", "1", "--out", "p.yaml") == 0
    assert cb(monkeypatch, *LEARN, "--episodes", "2", "--out", "p.yaml", "--resume") == 2
    assert "algorithm was monte_carlo, is accommodate" in capsys.readouterr().err


def test_plugin_learner_is_listed_with_its_constants(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "learners", "--json") == 0
    *_, shown = json.loads(capsys.readouterr().out)
    assert (shown["learner"], shown["package"]) == ("monte_carlo", "demo 1.0")
    patience = {"constant": "patience", "default": 60.0, "unit": "s"}
    assert patience.items() <= shown["constants"][2].items()
    assert "### Learner monte_carlo" in page()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import nothing_like_it", "No module named 'nothing_like_it'"),
        ("from builtins import dict as Odd", "lacks the methods see, remember"),
        (
            "from demo.monte_carlo import MonteCarlo\nclass Odd(MonteCarlo): Constants = int",
            "lacks Constants",
        ),
    ],
)
def test_broken_plugin_learner_is_named_and_others_work(
    text: str,
    reason: str,
    here: Path,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write_package(folder, "odd", {LEARNERS.group: {"odd": "oddly:Odd"}}, oddly=text)
    LEARNERS.refresh()
    assert cb(monkeypatch, "show", "learners") == 0
    out, err = capsys.readouterr()
    assert "accommodate" in out and "monte_carlo" in out
    assert "learner 'odd' (package odd 1.0, group cbdsl.learners): " in err and reason in err
    assert cb(monkeypatch, *LEARN, "--learner", "odd", "--out", "p.yaml") == 2
    assert reason in capsys.readouterr().err
