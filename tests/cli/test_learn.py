"""``cb learn``: mistakes are found before the episodes, and what is learned can be run."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from cbdsl.cli import main as command
from cbdsl.control import multigrid
from cbdsl.training.knowledge import policy_document
from cbdsl.yaml_text.writer import write
from tests.cli.test_run import STUCK
from tests.conftest import ROOT
from tests.training.toy import toy_provenance, toy_trial

OTHER_STAGE = "cbdsl: 1\nkind: stage\nname: elsewhere\nrobot: other\ncontexts: {only: {}}\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with what can be in the way."""
    (tmp_path / "elsewhere.yaml").write_text(OTHER_STAGE, encoding="utf-8")
    (tmp_path / "folder.yaml").mkdir()
    (tmp_path / "taken.yaml").write_text("not learned", encoding="utf-8")
    (tmp_path / "begun.episodes.jsonl").write_text("", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def cb(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    """Run ``cb`` in this process; its exit code."""
    monkeypatch.setattr(sys, "argv", ["cb", *words])
    try:
        command.main()
    except SystemExit as end:
        return int(end.code or 0)
    return 0


# What is asked for, the exit code, and what the message has to name.
MISTAKES = [
    (["searchtrack"], 2, ["--out"]),
    (["serchtrack", "--out", "a.yaml"], 2, ["did you mean 'searchtrack'"]),
    (["searchtrack", "--out", "a.yaml", "--stage", "elsewhere.yaml"], 1, ["other"]),
    (["searchtrack", "--out", "a.yaml", "--backend", "gazebo"], 2, ["gazebo", "bullet"]),
    (["searchtrack", "--out", "a.yaml", "--gamma", "1.5"], 2, ["--gamma"]),
    (["searchtrack", "--out", "a.yaml", "--density", "round"], 2, ["kernel or gaussian"]),
    (["searchtrack", "--out", "a.yaml", "--episodes", "0"], 2, ["--episodes"]),
    (["searchtrack", "--out", "a.json"], 2, ["a.json", "<name>.yaml"]),
    (["searchtrack", "--out", "a b.yaml"], 2, ["a b.yaml", "<name>.yaml"]),
    (["searchtrack", "--out", "folder.yaml"], 2, ["folder.yaml", "folder"]),
    (["searchtrack", "--out", "taken.yaml/a.yaml"], 2, ["taken.yaml/a.yaml", "exists"]),
    (["searchtrack", "--out", "taken.yaml"], 2, ["taken.yaml is there already"]),
    (["searchtrack", "--out", "begun.yaml"], 2, ["begun.episodes.jsonl", "--resume"]),
]


@pytest.mark.parametrize(
    ("words", "code", "named"), MISTAKES, ids=[" ".join(each[0]) for each in MISTAKES]
)
def test_a_mistake_is_one_clear_message(
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    words: list[str],
    code: int,
    named: list[str],
) -> None:
    before = {path: path.is_file() and path.read_bytes() for path in here.iterdir()}
    assert cb(monkeypatch, "learn", *words) == code
    said = "".join(capfd.readouterr())
    assert "Traceback" not in said and "internal error" not in said
    assert all(part in said for part in named)
    assert {path: path.is_file() and path.read_bytes() for path in here.iterdir()} == before


LEARN = ["learn", "searchtrack", "--stage", "searchtrack_training", "--seed", "3"]


@pytest.mark.slow
def test_what_is_learned_on_bullet_goes_on_validates_and_runs(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *LEARN, "--episodes", "4", "--out", "policy.yaml") == 0
    words = ("--resume", "--out", "policy.yaml", "--episodes", "20")
    assert cb(monkeypatch, *LEARN, *words) == 0
    (here / "at_once").mkdir()
    assert cb(monkeypatch, *LEARN, "--episodes", "20", "--out", "at_once/policy.yaml") == 0
    for name in ("policy.yaml", "policy_head.yaml"):
        assert (here / name).read_bytes() == (here / "at_once" / name).read_bytes()
    assert "episode 20 of 20" in capsys.readouterr().out
    assert cb(monkeypatch, "validate", "policy.yaml", "policy_head.yaml") == 0
    capsys.readouterr()
    run = ["run", "searchtrack", "--stage", "searchtrack_training", "--policy", "policy.yaml"]
    assert cb(monkeypatch, *run, "--episodes", "5", "--seed", "500", "--json") == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    presented = [row for row in rows if row["context"] == "presented"]
    assert presented and all(row["rewarded"] for row in presented)


def test_a_policy_of_a_program_that_changed_is_refused_before_it_runs(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "programs" / "searchtrack.yaml").read_text("utf-8")
    program = here / "searchtrack.yaml"
    program.write_text(text.replace("gain: 8 /s", "gain: 4 /s"), encoding="utf-8")
    trial = toy_trial()
    write(policy_document(trial, toy_provenance(trial, 1), "policy"), here / "policy.yaml")
    assert cb(monkeypatch, "run", "searchtrack.yaml", "--policy", "policy.yaml") == 1
    assert "CB622" in capsys.readouterr().out
    # Its own policy, its stage and what is said of it may change: they were not learned from.
    others = text.replace("table_right", "absent").replace('  "*1": search\n', "")
    program.write_text(f"# Another comment.\n{others}", encoding="utf-8")
    assert cb(monkeypatch, "validate", "policy.yaml") == 0


def test_what_stops_an_episode_is_one_clear_message(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (here / "stuck.yaml").write_text(STUCK, encoding="utf-8")
    monkeypatch.setattr(multigrid, "_CYCLES", 0)
    assert cb(monkeypatch, "learn", "stuck.yaml", "--backend", "kinematic", "--out", "a.yaml") == 2
    _, err = capfd.readouterr()
    assert len(err.splitlines()) == 1
    assert "0.00 s: no convergence in 0 cycles" in err and "a.episodes.jsonl" in err
