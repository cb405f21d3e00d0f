"""``cb explore``: mistakes are reported before any motion, and no recorded action is repeated."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from cbdsl.api.requests.explored_actions import read_action
from cbdsl.checking.document import check_document
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.catalog import CatalogDocument
from cbdsl.training.exploration.action_runner import ActionRunner
from cbdsl.yaml_text.library import Library
from tests.cli.test_learn import cb
from tests.conftest import ROOT

ON = ["--stage", "exploring_basketball", "--feature", "yellow", "--backend", "kinematic"]
LOOK = ["explore", "searchtrack", *ON, "--seed", "4"]

MISTAKES = [
    (["explore", "serchtrack", *ON, "--out", "a.yaml"], ["did you mean 'searchtrack'"]),
    (["explore", "searchtrack", *ON, "--out", "a.txt"], ["a.txt", "<name>.yaml"]),
    (["explore", "a=searchtrack", "a=reachtouch", *ON, "--out", "a.yaml"], ["two actions", "'a'"]),
    (["explore", "posture", *ON, "--out", "a.yaml"], ["'posture'", "rewarded"]),
    (["explore", "visualinspect:mark", *ON, "--out", "a.yaml"], ["visualinspect:mark", "LABEL="]),
    (["explore", "searchtrack:color=red", *ON, "--out", "a.yaml"], ["color"]),
    ([*LOOK, "--algorithm", "explore", "--out", "a.yaml"], ["explore_catalog"]),
    ([*LOOK, "--set", "temperature_=1", "--out", "a.yaml"], ["did you mean 'temperature'"]),
    ([*LOOK, "--set", "alpha=0", "--out", "a.yaml"], ["alpha = 0"]),
    ([*LOOK, "--out", "taken.yaml"], ["taken.yaml", "not explored here"]),
    ([*LOOK, "--out", "begun.yaml"], ["--resume"]),
    ([*LOOK[:2], "--stage", "table_right", "--out", "a.yaml"], ["persistent", "table_right"]),
]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "taken.yaml").write_text("not explored", encoding="utf-8")
    (tmp_path / "begun.actions.jsonl").write_text("", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("words", "named"), MISTAKES, ids=lambda each: str(each)[-60:])
def test_explore_with_wrong_arguments_names_the_mistake(
    words: list[str],
    named: list[str],
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, *words) in (1, 2)
    told = "".join(capsys.readouterr())
    assert all(each in told for each in named), told
    assert "internal error" not in told
    assert not (here / "a.yaml").exists()


@pytest.mark.parametrize(
    ("text", "label", "program", "values"),
    [
        ("reachtouch", "reachtouch", "reachtouch", {}),
        ("reachtouch:feature=red", "reachtouch_red", "reachtouch", {"feature": "red"}),
        ("touch=programs/p.yaml:a=b", "touch", "programs/p.yaml", {"a": "b"}),
        ("visualinspect:mark=?", "visualinspect", "visualinspect", {"mark": "?"}),
    ],
)
def test_action_words_are_parsed(
    text: str, label: str, program: str, values: dict[str, str]
) -> None:
    assert read_action(text) == (label, program, values)


def test_invalid_action_is_reported() -> None:
    for text in ("", ":a=b", "2=reachtouch", "reachtouch:feature="):
        with pytest.raises(UsageError, match="is not an action"):
            read_action(text)


def catalog(path: Path) -> CatalogDocument:
    assert not check_document(path)
    return Library().read(path, CatalogDocument).document


def rows(path: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()[1:]]


def test_catalog_is_explored_resumed_and_shown(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["explore", "searchtrack", "reachtouch", *ON, "--seed", "4", "--out", "ball.yaml"]
    assert cb(monkeypatch, *words, "--actions", "5") == 0
    first = catalog(here / "ball.yaml")
    assert sum(each.tried for each in first.affordances.values()) >= 3
    kept = rows(here / "ball.actions.jsonl")
    assert cb(monkeypatch, *words, "--actions", "8", "--resume") == 0
    later = rows(here / "ball.actions.jsonl")
    assert later[:5] == kept and len(later) == 8
    whole = catalog(here / "ball.yaml")
    assert whole.steps is not None and first.steps is not None
    assert whole.steps.action[:5] == first.steps.action
    assert whole.steps.reward[:5] == first.steps.reward
    capsys.readouterr()
    assert cb(monkeypatch, "show", "catalog", "ball.yaml") == 0
    shown = capsys.readouterr().out
    assert "searchtrack" in shown and "95 % interval" in shown and "stereo.yellow" in shown
    assert cb(monkeypatch, "show", "catalog", "ball.yaml", "--against", "ball.yaml") == 0
    assert capsys.readouterr().out == "no difference\n"
    assert cb(monkeypatch, "show", "catalog", "ball.yaml", "--svg") == 0
    assert capsys.readouterr().out.startswith("<svg")
    assert cb(monkeypatch, *words, "--actions", "8", "--resume", "--set", "alpha=0.9") == 2
    assert "alpha was 0.3, is 0.9" in "".join(capsys.readouterr())


def test_actions_join_an_exploration_that_has_begun(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    to = [*ON, "--seed", "4", "--out", "ball.yaml"]
    assert cb(monkeypatch, "explore", "searchtrack", *to, "--actions", "5") == 0
    before = rows(here / "ball.actions.jsonl")
    both = ["explore", "searchtrack", "reachtouch", *to, "--actions", "9"]
    capsys.readouterr()
    assert cb(monkeypatch, *both, "--resume") == 2
    assert "reachtouch was nothing" in (told := capsys.readouterr().err) and "--join" in told
    assert cb(monkeypatch, *both, "--join") == 0
    later = rows(here / "ball.actions.jsonl")
    assert later[:5] == before and list(later[5]) == ["joined"]
    assert {each["action"] for each in later[:5]} <= {"searchtrack", "noop"}
    # Exploration attends to the new action.
    assert "reachtouch" in [each["action"] for each in later[6:]]
    grown = catalog(here / "ball.yaml")
    assert grown.provenance is not None and grown.provenance.actions == 9
    (joined,) = grown.provenance.joined
    assert (joined.after, joined.programs) == (5, ("reachtouch",))
    assert joined.stage == grown.provenance.stage
    # The joined exploration resumes like any other, and no action may leave it.
    assert cb(monkeypatch, *both[:-1], "10", "--resume") == 0
    assert len(rows(here / "ball.actions.jsonl")) == 11
    capsys.readouterr()
    left = ["explore", "reachtouch", *to, "--actions", "11", "--join"]
    assert cb(monkeypatch, *left) == 2
    assert "the earlier programs and policies remain" in capsys.readouterr().err


def test_action_that_cannot_run_is_left_out_and_the_rest_goes_on(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from cbdsl.runtime.episode import EpisodeError

    act = ActionRunner._act

    def faulty(self: ActionRunner, name: str, *rest: object) -> object:
        if name == "reachtouch":
            raise EpisodeError("the hand is gone")
        return act(self, name, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(ActionRunner, "_act", faulty)
    words = ["explore", "searchtrack", "reachtouch", *ON, "--seed", "4", "--out", "ball.yaml"]
    assert cb(monkeypatch, *words, "--actions", "12") == 0
    assert "reachtouch is left out from now on: the hand is gone" in capsys.readouterr().out
    found = catalog(here / "ball.yaml").affordances
    assert (found["reachtouch"].tried, found["reachtouch"].failed) == (1, "the hand is gone")
    assert found["searchtrack"].rewarded == found["searchtrack"].tried > 0


def test_missing_object_is_reported(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["explore", "searchtrack", *ON, "--seed", "4", "--out", "gone.yaml"]
    words[words.index("yellow")] = "blue"
    assert cb(monkeypatch, *words, "--actions", "7", "--set", "longest=2 s") == 0
    assert "nothing that can be acted on" in capsys.readouterr().out
    assert catalog(here / "gone.yaml").affordances["searchtrack"].rewarded == 0


def test_expect_prints_predictions_beside_outcomes(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["explore", "searchtrack", *ON, "--seed", "4", "--out", "ball.yaml"]
    assert cb(monkeypatch, *words, "--actions", "4") == 0
    capsys.readouterr()
    expect = ["--expect", "exploring_basketball", "--scenes", "3", "--backend", "kinematic"]
    assert cb(monkeypatch, "show", "catalog", "ball.yaml", *expect, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["predictions"]) == 3 and 0 <= told["brier"] <= 1
    errors = [(each["probability"] - each["rewarded"]) ** 2 for each in told["predictions"]]
    assert told["brier"] == pytest.approx(sum(errors) / 3)


def test_damaged_journal_names_its_line(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [*LOOK, "--out", "ball.yaml"]
    assert cb(monkeypatch, *words, "--actions", "2") == 0
    journal = here / "ball.actions.jsonl"
    whole = journal.read_text("utf-8")
    assert json.loads(whole.splitlines()[2])["action"]
    changes = {
        "it lacks 'ahead'": ('"ahead"', '"behind"'),
        "it is not an action": ('"sim_seconds": ', '"sim_seconds": "x", "t": '),
        "unknown action 'fly'": ('"action": "', '"action": "fly", "_": "'),
        "names no actions": ('"action"', '"joined": 5, "action"'),
    }
    for named, change in changes.items():
        first, second, third = whole.splitlines(keepends=True)
        journal.write_text(first + second + third.replace(*change), encoding="utf-8")
        assert cb(monkeypatch, *words, "--actions", "3", "--resume") == 2
        told = "".join(capsys.readouterr())
        assert "ball.actions.jsonl, line 3: " in told and named in told


def ended(process: subprocess.Popen[bytes], done: Callable[[], bool]) -> None:
    """Kill a process once a condition holds."""
    deadline = time.monotonic() + 120
    while not done() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()


@pytest.mark.slow
def test_killed_exploration_loses_at_most_one_action(here: Path) -> None:
    words = [*LOOK, "--actions", "9", "--out", "ball.yaml"]
    journal, total = here / "ball.actions.jsonl", 0

    def count() -> int:
        return journal.read_bytes().count(b"\n") - 1 if journal.exists() else 0

    for _ in range(3):
        start = count()
        more = ["--resume"] if journal.exists() else []
        process = subprocess.Popen(
            [sys.executable, "-c", "from cbdsl.cli.main import main; main()", *words, *more],
            cwd=here,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=subprocess.DEVNULL,
        )
        ended(process, lambda start=start: count() >= start + 2)  # type: ignore[misc]
        assert count() >= max(total, start)
        total = count()
    assert total >= 6
