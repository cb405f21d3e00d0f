"""``cb why``: a sentence for a failure, the families ruled out, and refusals."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from cbdsl.api.load import load
from cbdsl_why.patches import patches
from tests.cli.arm_program import TEXT
from tests.cli.test_main import cb
from tests.conftest import ROOT
from tests.reporting.conftest import Record
from tests.reporting.test_page import header_of
from tests.runtime.synthetic import World


@pytest.fixture(scope="module")
def blind(record: Record) -> Path:
    """Return the recording of a search without an object."""
    return record("searchtrack", begin=lambda rng: World())


def test_why_of_a_recording_prints_time_tick_and_cause(
    blind: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "why", str(blind)) == 0
    told = capsys.readouterr().out
    assert "at 0.00 s (tick 0), never seen: sat_10 was never seen, and track needs" in told


def test_why_as_json_has_the_cause_and_the_ruled_out_families(
    blind: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "why", str(blind), "--json") == 0
    row = json.loads(capsys.readouterr().out)
    assert (row["failed"], row["cause"]["kind"], row["cause"]["tick"]) == (True, "never_seen", 0)
    assert row["ruled_out"]


@pytest.fixture
def hasty(tmp_path: Path) -> Path:
    """Return a program whose actions have too little time."""
    file = tmp_path / "raise_arm.yaml"
    file.write_text(f"{TEXT}limits: {{transition_time: 2 s}}  # too short\n", "utf-8")
    return file


KINEMATIC = ("--backend", "kinematic", "--seed", "3")


def test_why_tries_changes_and_applies_the_one_that_helps(
    hasty: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = hasty.read_text("utf-8")
    assert cb(monkeypatch, "why", str(hasty), *KINEMATIC, "--json", "--try") == 0
    row = json.loads(capsys.readouterr().out)
    assert row["patch"]["edit"].endswith("limits.transition_time: 2 s -> 4 s")
    assert (row["patch"]["before"], row["patch"]["after"], row["patch"]["seeds"]) == (0, 5, 5)
    assert hasty.read_text("utf-8") == before
    assert cb(monkeypatch, "why", str(hasty), *KINEMATIC, "--apply") == 0
    assert "changed " in capsys.readouterr().out
    assert hasty.read_text("utf-8") == before.replace("2 s}", "4 s}")
    assert cb(monkeypatch, "run", str(hasty), *KINEMATIC, "--json") == 0
    assert json.loads(capsys.readouterr().out)["succeeded"]


def test_why_changes_no_file_behind_a_link_in_a_folder(
    hasty: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = hasty.read_text("utf-8")
    link = hasty.parent / "theirs" / "programs" / hasty.name
    link.parent.mkdir(parents=True)
    link.symlink_to(hasty)
    monkeypatch.chdir(link.parent.parent)
    assert cb(monkeypatch, "why", hasty.stem, *KINEMATIC, "--apply") == 2
    assert "links are followed for given names only" in capsys.readouterr().err
    assert hasty.read_text("utf-8") == before
    assert cb(monkeypatch, "why", f"programs/{hasty.name}", *KINEMATIC, "--apply") == 0
    assert link.is_symlink() and hasty.read_text("utf-8") != before


def test_why_offers_no_change_that_does_not_help(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("why", "reach", "--stage", "out_of_reach", "--backend", "kinematic", "--try")
    assert cb(monkeypatch, *words) == 0
    assert "tried changes raised the rate of success" in capsys.readouterr().out


def test_patches_change_one_number_and_neither_goals_nor_tolerances(hasty: Path) -> None:
    request = load(str(hasty))
    made = patches(request, "time")
    assert made[0].keys == ("limits", "transition_time")
    assert len({each.text for each in made}) == len(made)
    text = hasty.read_text("utf-8").splitlines()
    for patch in made:
        changed = patch.text.splitlines()
        assert [n + 1 for n, line in enumerate(text) if line != changed[n]] == [patch.line]
        assert patch.keys[-1] not in ("tolerance", "within", "arrival", "rate")
        assert not patch.before.startswith("[")


def test_why_refuses_to_try_changes_of_a_recording(
    blind: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "why", str(blind), "--try") == 2
    assert "a recording cannot run again" in capsys.readouterr().err


@pytest.mark.parametrize("option", [("--workers", "2"), ("--watch",)], ids=lambda each: each[0])
def test_why_refuses_options_without_an_effect(
    option: tuple[str, ...],
    hasty: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, "why", str(hasty), *KINEMATIC, *option) == 2
    assert "--workers and --watch are for cb run" in capsys.readouterr().err


def test_why_of_a_success_has_nothing_to_explain(
    kept: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "why", str(kept)) == 0
    assert "it did not fail" in capsys.readouterr().out


def test_why_of_a_program_runs_it_and_marks_the_moment_on_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"
    words = ("why", "reach", "--stage", "out_of_reach", "--backend", "kinematic", "--seed", "1")
    assert cb(monkeypatch, *words, "--page", str(page), "--no-open") == 0
    assert "out of reach: approach stayed" in capsys.readouterr().out
    header = header_of(page.read_text("utf-8"))
    assert header["failed"] and header["causes"][0]["kind"] == "out_of_reach"
    assert header["causes"][0]["text"].startswith("approach stayed")


def test_why_of_a_program_that_changed_since_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "programs/searchtrack.yaml").read_text("utf-8")
    program = tmp_path / "searchtrack.yaml"
    program.write_text(text.replace("transitions: 100", "transitions: 2"), "utf-8")
    words = ("--stage", "absent", "--backend", "kinematic", "--record", "tapes")
    cb(monkeypatch, "run", str(program), *words)
    cb(monkeypatch, "why", "tapes")
    assert "changed" not in capsys.readouterr().out
    program.write_text(text, "utf-8")
    cb(monkeypatch, "why", "tapes")
    assert "searchtrack.yaml has changed since" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "told"),
    [("missing.json", "missing"), ("version.json", "version 1")],
)
def test_why_of_a_faulty_recording_is_refused_with_the_reason(
    name: str,
    told: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = '{"cbdsl": 1, "kind": "recording", "version": 1}'
    (tmp_path / "version.json").write_text(text, "utf-8")
    assert cb(monkeypatch, "why", str(tmp_path / name)) == 2
    assert told in capsys.readouterr().err


def test_why_of_a_folder_explains_the_recordings_beside_a_damaged_one(
    blind: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for suffix in (".json", ".npz"):
        shutil.copy(blind.with_suffix(suffix), tmp_path / f"episode_7{suffix}")
    (tmp_path / "episode_1.npz").write_bytes(b"PK")  # killed before its JSON file
    assert cb(monkeypatch, "why", str(tmp_path), "--json") == 2
    out, err = capsys.readouterr()
    assert [json.loads(line)["cause"]["kind"] for line in out.splitlines()] == ["never_seen"]
    assert "episode_1.json: missing; this recording was cut short" in err


_FAR = """\
cbdsl: 1
kind: program
name: far
robot: dexter
stage: absent
controllers:
  reach:
    potential: spring
    reference: [2 m, -1 m, 1 m]
    feedback: right_arm.position
    effector: right_arm.position
steps:
  reach: {exits: [reach stuck: fail the place is too far, reach at rest: fail it is near]}
limits: {transitions: 4, transition_time: 20 s}
"""


def test_why_states_the_reason_of_a_member_that_is_stuck(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    program = tmp_path / "far.yaml"
    program.write_text(_FAR, "utf-8")
    cb(monkeypatch, "why", str(program), "--backend", "kinematic", "--json")
    row = json.loads(capsys.readouterr().out)
    (stated,) = [each for each in (row["cause"], *row["others"]) if each["kind"] == "stated"]
    assert stated["sentence"] == "far states in 1: the place is too far"


def test_why_of_a_program_that_came_to_rest_without_rewards_has_nothing_to_explain(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "why", "posture", "--backend", "kinematic") == 0
    assert "it did not fail. Done after" in capsys.readouterr().out
