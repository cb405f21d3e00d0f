"""``cb learn``: mistakes are reported before the episodes, and learned policies can be run."""

from __future__ import annotations

import fcntl
import json
import sys
from pathlib import Path

import pytest

from cbdsl.cli import main as command
from cbdsl.control.potentials import multigrid
from cbdsl.training.trial_work import learned_documents
from cbdsl.yaml_text.writer import write
from tests.cli.test_run import STUCK
from tests.conftest import ROOT
from tests.training.toy import toy_provenance, toy_trial

OTHER_STAGE = "cbdsl: 1\nkind: stage\nname: elsewhere\nrobot: other\ncontexts: {only: {}}\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to a working folder with files and folders that conflict with outputs."""
    (tmp_path / "elsewhere.yaml").write_text(OTHER_STAGE, encoding="utf-8")
    (tmp_path / "folder.yaml").mkdir()
    (tmp_path / "taken.yaml").write_text("not learned", encoding="utf-8")
    (tmp_path / "begun.episodes.jsonl").write_text("", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def cb(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    """Run ``cb`` in this process and return its exit code."""
    monkeypatch.setattr(sys, "argv", ["cb", *words])
    try:
        command.main()
    except SystemExit as end:
        return int(end.code or 0)
    return 0


# Options that take real numbers.
MEASURED = (
    *("gamma", "alpha", "epsilon", "bandwidth", "prior"),
    *("transition-time", "idle-time", "episode-time"),
)

# Arguments, exit code and required parts of the message.
MISTAKES = [
    (["searchtrack"], 2, ["--out"]),
    (["serchtrack", "--out", "a.yaml"], 2, ["did you mean 'searchtrack'"]),
    (["searchtrack", "--out", "a.yaml", "--stage", "elsewhere.yaml"], 1, ["other"]),
    (["searchtrack", "--out", "a.yaml", "--backend", "gazebo"], 2, ["gazebo", "bullet"]),
    (["searchtrack", "--out", "a.yaml", "--gamma", "1.5"], 2, ["gamma = 1.5"]),
    (
        ["searchtrack", "--out", "a.yaml", "--exploring-episodes", "-1"],
        2,
        ["exploring_episodes = -1"],
    ),
    *(
        (["searchtrack", "--out", "a.yaml", f"--{option}", "inf"], 2, [option])
        for option in MEASURED
    ),
    *(
        (["searchtrack", "--out", "a.yaml", f"--{option}", "nan"], 2, [option])
        for option in MEASURED
    ),
    (["searchtrack", "--out", "a.yaml", "--trials", "1" + "0" * 30], 2, ["--trials"]),
    (["searchtrack", "--out", "a.yaml", "--density", "round"], 2, ["'kernel' or 'gaussian'"]),
    (
        ["searchtrack", "--out", "a.yaml", "--workers", "2", "--scheduler", "tcp://here:1"],
        2,
        ["--workers", "--scheduler", "choose"],
    ),
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
def test_learn_with_wrong_arguments_prints_one_message(
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


def test_episode_ends_at_the_requested_time(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """``--episode-time`` also bounds the search that a reach uses, which lasts many transitions."""
    words = ["learn", "reachtouch", "--stage", "absent", "--backend", "kinematic", "--seed", "3"]
    words += ["--episodes", "2", "--episode-time", "6", "--out", "short.yaml"]
    assert cb(monkeypatch, *words) == 0
    first, *rows = map(json.loads, Path("short.episodes.jsonl").read_text().splitlines())
    assert first["constants"]["episode_time"] == 6.0
    assert len(rows) == 2
    assert all(5.9 < row["sim_seconds"] < 6.1 for row in rows)


BEGUN = [
    *("learn", "searchtrack", "--stage", "searchtrack_training", "--backend", "kinematic"),
    *("--seed", "3", "--episodes", "2", "--out", "begun.yaml"),
]

# Options after those of BEGUN, and the difference that the message reports.
OTHERS = [
    ([], "go on with --resume"),
    (["--resume", "--seed", "4"], "seed was 3, is 4"),
    (["--resume", "--gamma", "0.5"], "gamma was 0.8, is 0.5"),
    (["--resume", "--density", "gaussian"], "density was kernel, is gaussian"),
    (["--resume", "--exploring-episodes", "1"], "exploring_episodes was nothing, is 1"),
    (["--resume", "--transitions", "9"], "transitions was 100, is 9"),
    (["--resume", "--backend", "bullet"], "backend was kinematic, is bullet"),
    (["--resume", "--stage", "absent"], "stage was searchtrack_training, is absent"),
    (["--resume", "--with", "feature=sat_3"], "feature was sat_10, is sat_3"),
    (["--resume", "--sequential"], "actions was search, track, search ◁ track"),
]


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a finished trial."""
    folder = tmp_path_factory.mktemp("begun")
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.chdir(folder)
        assert cb(monkeypatch, *BEGUN) == 0
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


@pytest.mark.parametrize(("words", "told"), OTHERS, ids=[" ".join(each[0]) for each in OTHERS])
def test_resume_of_another_trial_is_refused_with_the_difference(
    begun: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    told: str,
) -> None:
    monkeypatch.chdir(begun)
    before = contents(begun)
    assert cb(monkeypatch, *BEGUN, *words) == 2
    said = capsys.readouterr().err
    assert told in said and "begun.episodes.jsonl" in said
    assert contents(begun) == before


def test_resume_after_a_change_of_the_program_is_refused(
    begun: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "programs" / "searchtrack.yaml").read_text("utf-8")
    changed = tmp_path / "searchtrack.yaml"
    changed.write_text(text.replace("gain: 8 /s", "gain: 4 /s"), encoding="utf-8")
    monkeypatch.chdir(begun)
    words = [str(changed) if word == "searchtrack" else word for word in BEGUN]
    assert cb(monkeypatch, *words, "--resume") == 2
    assert "program 'searchtrack' has changed since" in capsys.readouterr().err


def test_foreign_file_in_the_place_of_a_model_is_reported_before_the_episodes(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "new_head.yaml").write_text("not learned", encoding="utf-8")
    assert cb(monkeypatch, *BEGUN, "--out", "new.yaml") == 2
    assert "new_head.yaml is there already" in capsys.readouterr().err
    assert not (here / "new.episodes.jsonl").exists()


def test_unusable_folder_of_models_is_reported_before_the_episodes(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "models").write_text("no folder", encoding="utf-8")
    assert cb(monkeypatch, *BEGUN, "--out", "policies/new.yaml") == 2
    assert f"a file exists where a folder is needed ({here / 'models'})" in capsys.readouterr().err
    assert list((here / "policies").iterdir()) == []


def test_start_of_a_resumed_trial_is_reported(
    begun: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(begun)
    before = contents(begun)
    assert cb(monkeypatch, *BEGUN, "--episodes", "1", "--resume") == 0
    assert "the first 1 of its 2 episodes count, all are kept" in capsys.readouterr().out
    assert cb(monkeypatch, *BEGUN, "--resume") == 0
    assert "2 of 2 episodes are over" in capsys.readouterr().out
    assert contents(begun) == before
    assert cb(monkeypatch, *BEGUN, "--resume", "--out", "other.yaml") == 0
    assert "nothing to go on with" in capsys.readouterr().out
    for name in ("other.yaml", "other_head.yaml", "other.episodes.jsonl"):
        (begun / name).unlink(missing_ok=True)


def test_two_processes_are_never_at_work_on_one_trial(
    begun: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(begun)
    with (begun / "begun.episodes.jsonl").open("rb") as journal:
        fcntl.flock(journal, fcntl.LOCK_EX)
        assert cb(monkeypatch, *BEGUN, "--resume") == 2
    assert "another process is at work on" in capsys.readouterr().err


def test_trials_in_a_row_are_numbered_and_more_can_follow(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [*BEGUN, "--out", "many.yaml", "--episodes", "1"]
    assert cb(monkeypatch, *words, "--trials", "2") == 0
    first = (here / "many_1.episodes.jsonl").read_bytes()
    assert cb(monkeypatch, *words, "--trials", "3", "--resume") == 0
    assert (here / "many_1.episodes.jsonl").read_bytes() == first
    assert sorted(file.name for file in here.glob("many_?.yaml")) == [
        *("many_0.yaml", "many_1.yaml", "many_2.yaml")
    ]
    assert "trial 2, episode 1 of 1" in capsys.readouterr().out


LEARN = ["learn", "searchtrack", "--stage", "searchtrack_training", "--seed", "3"]


@pytest.mark.slow
def test_policy_learned_on_bullet_resumes_validates_and_runs(
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


def test_policy_of_a_program_that_changed_is_refused_before_it_runs(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "programs" / "searchtrack.yaml").read_text("utf-8")
    program = here / "searchtrack.yaml"
    program.write_text(text.replace("gain: 8 /s", "gain: 4 /s"), encoding="utf-8")
    trial = toy_trial()
    write(learned_documents(trial, toy_provenance(trial, 1), "policy")[-1], here / "policy.yaml")
    assert cb(monkeypatch, "run", "searchtrack.yaml", "--policy", "policy.yaml") == 1
    assert "CB622" in capsys.readouterr().out
    # The program's own policy, stage and comments may change, because learning does not use them.
    others = text.replace("table_right", "absent").replace('  "*1": search\n', "")
    program.write_text(f"# Another comment.\n{others}", encoding="utf-8")
    assert cb(monkeypatch, "validate", "policy.yaml") == 0


def test_unsolvable_field_ends_learning_with_one_message(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (here / "stuck.yaml").write_text(STUCK, encoding="utf-8")
    monkeypatch.setattr(multigrid, "_CYCLES", 0)
    assert cb(monkeypatch, "learn", "stuck.yaml", "--backend", "kinematic", "--out", "a.yaml") == 2
    _, err = capfd.readouterr()
    # The first run after an installation also prints the notice of compilation.
    (line,) = [line for line in err.splitlines() if not line.startswith("compiling")]
    assert "0.00 s: no convergence in 0 cycles" in line and "a.episodes.jsonl" in line
