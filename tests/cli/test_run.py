"""``cb run``: one clear message for each mistake, and repeatable results."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import BACKENDS
from cbdsl.control.potentials import multigrid
from cbdsl.reporting.recorded import read_recording
from cbdsl.runtime.recording import Recording
from cbdsl.runtime.tick import Tick
from tests.cli import test_main
from tests.conftest import ROOT

OTHER_STAGE = "cbdsl: 1\nkind: stage\nname: elsewhere\nrobot: other\ncontexts: {only: {}}\n"
OTHER_POLICY = (
    "cbdsl: 1\nkind: policy\nname: touching\nprogram: reachtouch\n"
    "predicates: [searchtrack, reach, touch]\npolicy: {'***': reach ◁ touch}\n"
)
BROKEN = (
    "cbdsl: 1\nkind: program\nname: broken\nrobot: dexter\ncontrollers: {go: "
    "{potential: spring, reference: 0, feedback: head, effector: head}}\nactions: [gone]\n"
)

STUCK = """\
cbdsl: 1
kind: program
name: stuck
robot: dexter
stage: absent
controllers:
  go:
    potential: harmonic
    reference: [70 cm, 0 m, 0 m]
    feedback: right_arm.position
    effector: right_arm.position
    field: {lower: [-1 m, -1 m, -1 m], upper: [1 m, 1 m, 1 m], spacing: 10 cm}
actions: [go]
policy: {"*": go}
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to a working folder with files that do not fit."""
    files = {
        "elsewhere.yaml": OTHER_STAGE,
        "touching.yaml": OTHER_POLICY,
        "broken.yaml": BROKEN,
        "episode_1.json": '{\n "cbdsl": 1,\n "kind": "recording"\n}\n',
        "file": "",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def cb(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Run ``cb run`` in this process and return its exit code."""
    return test_main.cb(monkeypatch, "run", *arguments)


def cb_process(*arguments: str, **changes: str | None) -> subprocess.CompletedProcess[str]:
    """Run ``cb`` in a separate process, with ``changes`` to its environment."""
    environment = {**os.environ, **{key: value for key, value in changes.items() if value}}
    for key in changes.keys() - {key for key, value in changes.items() if value}:
        environment.pop(key, None)
    script = "import sys; from cbdsl.cli.main import main; main()"
    return subprocess.run(
        [sys.executable, "-c", script, *arguments], capture_output=True, text=True, env=environment
    )


# Arguments, exit code and required parts of the message.
MISTAKES = [
    (["serchtrack"], 2, ["serchtrack", "did you mean 'searchtrack'", "known: "]),
    (["nowhere/none.yaml"], 1, ["nowhere/none.yaml:1:1", "No such file"]),
    (["folder"], 2, ["unknown program 'folder'", "known: "]),
    (["elsewhere.yaml"], 1, ["elsewhere.yaml:2:7", "stage", "program"]),
    (["broken.yaml"], 1, ["broken.yaml:6:", "gone"]),
    (["searchtrack", "--stage", "table_rihgt"], 2, ["did you mean 'table_right'"]),
    (["searchtrack", "--stage", "folder/none.yaml"], 1, ["folder/none.yaml:1:1"]),
    (["searchtrack", "--stage", "touching.yaml"], 1, ["touching.yaml:2:7", "stage"]),
    (["searchtrack", "--stage", "elsewhere.yaml"], 1, ["elsewhere.yaml", "other"]),
    (["searchtrack", "--context", "in_veiw"], 2, ["did you mean 'in_view'", "out_of_view"]),
    (["searchtrack", "--backend", "gazebo"], 2, ["gazebo", "bullet"]),
    (["searchtrack", "--with", "colour=red"], 2, ["colour"]),
    (["searchtrack", "--with", "feature"], 2, ["name=value"]),
    (["searchtrack", "--with", "feature=hue_99"], 1, ["CB501", "hue_99"]),
    (["searchtrack", "--policy", "touching.yaml"], 2, ["touching.yaml", "reachtouch"]),
    (["searchtrack", "--policy", "reachtouch"], 2, ["policies/reachtouch.yaml", "'reachtouch'"]),
    (["searchtrack", "--policy", "serchtrack"], 2, ["did you mean 'searchtrack'"]),
    (["searchtrack", "--policy", "none.yaml"], 1, ["none.yaml:1:1"]),
    (["searchtrack", "--policy", "episode_1.json"], 2, ["not a policy document", "recording"]),
    (["searchtrack", "--record", "file"], 2, ["--record file"]),
    (["searchtrack", "--record", "file/below"], 2, ["--record file/below"]),
    (["searchtrack", "--seed", "-1"], 2, ["--seed"]),
    (["searchtrack", "--episodes", "0"], 2, ["--episodes"]),
    (["searchtrack", "--seed", "one"], 2, ["--seed"]),
    (["searchtrack", "--explain", "--json"], 2, ["--explain", "--json", "choose"]),
    (["searchtrack", "--overwrite"], 2, ["--overwrite", "--record"]),
    (["searchtrack", "--record", ".", "--seed", "1"], 2, ["episode_1.json", "--overwrite"]),
    (["searchtrack", "--record", "elsewhere.yaml"], 2, ["a file exists where a folder is needed"]),
    ([], 2, ["program"]),
]


@pytest.mark.parametrize(
    ("arguments", "code", "named"), MISTAKES, ids=[" ".join(each[0]) for each in MISTAKES]
)
def test_run_with_wrong_arguments_prints_one_message(
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    arguments: list[str],
    code: int,
    named: list[str],
) -> None:
    assert cb(monkeypatch, *arguments) == code
    out, err = capfd.readouterr()
    assert "Traceback" not in err + out
    assert "internal error" not in err + out
    for part in named:
        assert part in out + err
    if code == 1:
        assert out.endswith("1 error\n")
    else:
        assert out == ""


_LOADED_LATE = tuple(f"cbdsl.{room}" for room in ("backends", "kinematics", "runtime", "sensing"))


@pytest.mark.parametrize("package", ["numpy", "pybullet", "cv2", "pinocchio"])
@pytest.mark.parametrize("more", [[], ["--record", "kept"]], ids=["run", "record"])
def test_run_without_the_simulator_names_the_extra(
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    package: str,
    more: list[str],
) -> None:
    for name in [*sys.modules]:
        if name == package or name.startswith(_LOADED_LATE):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    assert cb(monkeypatch, "searchtrack", "--backend", "bullet", *more) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert package in err
    assert "pip install 'cbdsl[" in err


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a screen is always there")
def test_window_without_a_screen_is_refused() -> None:
    done = cb_process("run", "searchtrack", "--gui", DISPLAY=None, WAYLAND_DISPLAY=None)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("cb: ") and done.stderr.count("\n") == 1
    assert "screen" in done.stderr or "display" in done.stderr.lower()


@pytest.mark.slow
def test_same_call_prints_the_same_bytes(tmp_path: Path) -> None:
    """Repeated calls differ in the wall time alone."""
    call = ("run", "reachtouch", "--stage", "table_right", "--seed", "70011", "--episodes", "2")
    runs = [cb_process(*call, "--json") for _ in range(2)]
    assert [run.returncode for run in runs] == [0, 0]
    assert [run.stderr for run in runs] == ["", ""]
    rows = [[json.loads(line) for line in run.stdout.splitlines()] for run in runs]
    assert [row["seed"] for row in rows[0]] == [70011, 70012]
    stripped = [re.sub(r'"wall_seconds": [^,}]+', "", run.stdout).encode() for run in runs]
    assert stripped[0] == stripped[1]


@pytest.mark.slow
def test_run_prints_transitions_and_writes_recordings(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "searchtrack", "--context", "in_view", "--record", "kept") == 0
    out, _ = capfd.readouterr()
    assert "XX -> " in out and "reward 1" in out and "Rewarded after" in out
    assert sorted(file.name for file in (here / "kept").iterdir()) == [
        "episode_0.json",
        "episode_0.npz",
    ]


def test_shipped_programs_are_found_from_anywhere(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert not (here / "programs").exists() and here != ROOT
    cb(monkeypatch, "none")
    assert "reachtouch" in capfd.readouterr().err


def test_unsolvable_field_ends_the_run_with_one_message(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (here / "stuck.yaml").write_text(STUCK, encoding="utf-8")
    monkeypatch.setattr(multigrid, "_CYCLES", 0)
    assert cb(monkeypatch, "stuck.yaml", "--backend", "kinematic", "--seed", "3") == 2
    _, err = capfd.readouterr()
    told = [line for line in err.splitlines() if not line.startswith("compiling")]
    assert told == ["cb: seed 3, 0.00 s: no convergence in 0 cycles"]


def test_renderer_is_printed_only_for_robots_with_cameras(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "poise", "--robot", "sixaxis", "--backend", "kinematic") == 0
    assert "image" not in capfd.readouterr().out
    cb(monkeypatch, "posture", "--backend", "kinematic")
    assert "images by ideal cameras" in capfd.readouterr().out


REACH = ("poise", "--robot", "sixaxis", "--backend", "kinematic", "--record", "kept")


def test_existing_recording_is_kept_without_overwrite(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *REACH) == 0
    files = sorted(file.name for file in (here / "kept").iterdir())
    assert files == ["episode_0.json", "episode_0.npz"]
    (here / "kept" / "episode_0.json").write_text("mine")
    capfd.readouterr()
    assert cb(monkeypatch, *REACH, "--episodes", "2") == 2
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1) and "kept/episode_0.npz" in err
    assert (here / "kept" / "episode_0.json").read_text() == "mine"
    assert cb(monkeypatch, *REACH, "--overwrite") == 0
    assert "recording" in (here / "kept" / "episode_0.json").read_text()


def test_episode_with_a_failed_recording_is_still_reported(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(np, "savez_compressed", full)
    assert cb(monkeypatch, *REACH, "--json") == 2
    out, err = capfd.readouterr()
    assert json.loads(out)["seed"] == 0
    assert err == "cb: --record kept/episode_0.npz: No space left on device\n"
    assert not list((here / "kept").iterdir())


@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGINT])
def test_recording_up_to_an_interrupt_is_kept(
    sent: signal.Signals,
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    ticks = 0

    def interrupt(recording: Recording, tick: Tick) -> None:
        nonlocal ticks
        ticks += 1
        noted(recording, tick)
        if ticks == 20:
            os.kill(os.getpid(), sent)

    noted = Recording.note_tick
    monkeypatch.setattr(Recording, "note_tick", interrupt)
    before = signal.getsignal(signal.SIGTERM)
    assert cb(monkeypatch, *REACH) == 130
    assert signal.getsignal(signal.SIGTERM) is before
    out, err = capfd.readouterr()
    assert "  Interrupted after " in out and "recorded in kept/episode_0.json" in out
    assert "Traceback" not in err
    assert len(read_recording(here / "kept" / "episode_0.json").arrays["time"]) == 20
    assert len(list((here / "kept").iterdir())) == 2


@pytest.mark.parametrize("command", ["run", "learn"])
def test_help_names_the_backends(
    command: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert test_main.cb(monkeypatch, command, "--help") == 0
    told = " ".join(capfd.readouterr().out.split())
    assert all(name in told for name in (*BACKENDS.builtins, "cb show backends"))


def test_run_page_writes_a_self_contained_page(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    words = ("poise", "--robot", "sixaxis", "--backend", "kinematic", "--page", "pages/reach.html")
    assert cb(monkeypatch, *words) == 0
    assert "pages/reach.html" in capfd.readouterr().out.splitlines()[-1]
    text = (here / "pages" / "reach.html").read_text("utf-8")
    assert "poise, seed 0" in text
    assert not re.search(r"""(src|href)=["']?(https?:)?//""", text)
    assert not [*here.rglob("*.npz")]
    assert cb(monkeypatch, *words, "--json") == 0
    (line,) = capfd.readouterr().out.splitlines()
    assert json.loads(line)["program"] == "poise"


def test_run_page_shows_the_episode_that_is_recorded_too(
    here: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    words = ("poise", "--robot", "sixaxis", "--backend", "kinematic", "--record", "kept")
    assert cb(monkeypatch, *words) == 0
    assert cb(monkeypatch, *words, "--seed", "7", "--page", "reach.html") == 0
    assert "seed 7" in (here / "reach.html").read_text("utf-8")
    assert (here / "kept" / "episode_7.npz").is_file()
    capfd.readouterr()


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["--page", "reach.txt"], "reach.txt: a page is <name>.html"),
        (["--page", "reach.html", "--episodes", "2"], "--page shows one episode, not 2"),
        (["--page", "file/reach.html"], "file/reach.html: cannot be written"),
    ],
)
def test_run_page_refuses_before_the_episode(
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    words: list[str],
    part: str,
) -> None:
    (here / "file").write_text("", encoding="utf-8")
    assert cb(monkeypatch, "poise", "--robot", "sixaxis", "--backend", "kinematic", *words) == 2
    out, err = capfd.readouterr()
    assert out == "" and part in err and err.count("\n") == 1
