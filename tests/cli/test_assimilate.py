"""Tests of ``cb learn --learner assimilate`` and ``cb run --schema`` on the kinematic backend."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.test_main import cb

LEARN = (
    *("learn", "reachtouch", "--learner", "assimilate", "--stage", "wide_table_training"),
    *("--backend", "kinematic", "--seed", "3", "--transition-time", "8", "--idle-time", "1"),
    *("--set", "least_samples=2"),
)
RUN = ("run", "reachtouch", "--stage", "wide_table_training", "--backend", "kinematic", "--json")


def test_schema_is_learned_resumed_and_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    once, again = tmp_path / "once.yaml", tmp_path / "again.yaml"
    learn = (*LEARN, "--from", "reachtouch")
    assert cb(monkeypatch, *learn, "--episodes", "6", "--out", str(once)) == 0
    assert cb(monkeypatch, *learn, "--episodes", "2", "--out", str(again)) == 0
    resumed = (*learn, "--episodes", "6", "--out", str(again), "--resume")
    assert cb(monkeypatch, *resumed) == 0
    assert once.read_text().replace("once", "again") == again.read_text()
    assert cb(monkeypatch, "validate", str(once)) == 0
    capsys.readouterr()
    assert cb(monkeypatch, *RUN, "--schema", str(once), "--episodes", "8", "--seed", "50") == 0
    episodes = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert sum(each["rewarded"] for each in episodes) >= 6
    actions = {action for each in episodes for action in each["actions"]}
    assert any(action.endswith(" with left_arm") for action in actions)
    assert any(action.endswith(" with right_arm") for action in actions)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (LEARN, "and none is named"),
        ((*LEARN, "--from", "searchtrack"), "serves program 'searchtrack'"),
        ((*LEARN, "--from", "reachtuch"), "did you mean 'reachtouch'"),
        (
            (*LEARN[:2], "--from", "reachtouch", "--learner", "accommodate"),
            "only assimilate, transfer and name_relations start from 'reachtouch'",
        ),
    ],
)
def test_unsuitable_program_for_assimilate_is_refused(
    words: tuple[str, ...],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, *words, "--out", str(tmp_path / "it.yaml")) == 2
    assert message in capsys.readouterr().err
