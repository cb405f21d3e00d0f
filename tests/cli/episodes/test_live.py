"""``--live``: its page changes no result, and leaves no process and no port."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import zlib
from http.client import HTTPConnection
from pathlib import Path

import pytest

from cbdsl.cli.episodes import live as module
from cbdsl.reporting.live.feed import Message
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.runtime.tick import Tick
from tests.cli.test_main import cb

REACH = ("run", "poise", "--robot", "sixaxis", "--backend", "kinematic", "--seed", "25", "--json")
LIVE = ("--live", "--fast", "--live-close")


def outcome(line: str) -> dict[str, object]:
    return {key: each for key, each in json.loads(line).items() if key != "wall_seconds"}


def test_run_with_a_page_equals_a_run_without_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *REACH) == 0
    alone = capsys.readouterr().out
    before = set(threading.enumerate())
    assert cb(monkeypatch, *REACH, *LIVE) == 0
    printed = capsys.readouterr()
    assert set(threading.enumerate()) == before
    assert outcome(printed.out) == outcome(alone), "the standard output is for scripts"
    url = re.search(r"live at http://127\.0\.0\.1:(\d+)/", printed.err)
    assert url is not None
    with socket.socket() as there:
        assert there.connect_ex(("127.0.0.1", int(url[1]))) != 0


def test_learning_with_a_page_learns_the_same(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("learn", "searchtrack", "--stage", "searchtrack_training", "--backend", "kinematic",
             "--episodes", "2", "--seed", "25")  # fmt: skip
    assert cb(monkeypatch, *words, "--out", "alone/looks.yaml") == 0
    assert cb(monkeypatch, *words, "--out", "shown/looks.yaml", *LIVE) == 0
    assert "live at http://127.0.0.1:" in capsys.readouterr().out
    alone, shown = (tmp_path / each / "looks.yaml" for each in ("alone", "shown"))
    assert shown.read_text("utf-8") == alone.read_text("utf-8")


def test_exploring_with_a_page_explores_the_same(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("explore", "searchtrack", "--stage", "exploring_basketball", "--feature", "yellow",
             "--backend", "kinematic", "--actions", "3", "--seed", "25")  # fmt: skip
    assert cb(monkeypatch, *words, "--out", "alone/ball.yaml") == 0
    capsys.readouterr()
    assert cb(monkeypatch, *words, "--out", "shown/ball.yaml", "--json", *LIVE) == 0
    printed = capsys.readouterr()
    assert "live at http://127.0.0.1:" in printed.err, "the standard output is for scripts"
    assert [json.loads(line)["number"] for line in printed.out.splitlines()] == [1, 2, 3]
    alone, shown = (tmp_path / each / "ball.yaml" for each in ("alone", "shown"))
    assert shown.read_text("utf-8") == alone.read_text("utf-8")


def test_page_of_an_exploration_receives_a_catalog_per_action(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    kept: list[Message] = []
    monkeypatch.setattr(LiveView, "keep", lambda self, message: kept.append(message))
    words = ("explore", "searchtrack", "--stage", "exploring_basketball", "--feature", "yellow",
             "--backend", "kinematic", "--seed", "25", "--out", "ball.yaml", *LIVE)  # fmt: skip
    assert cb(monkeypatch, *words, "--actions", "2") == 0
    assert cb(monkeypatch, *words, "--actions", "3", "--resume") == 0
    catalogs = [json.loads(each.event.split(b"data: ", 1)[1]) for each in kept]
    assert [each["over"] for each in catalogs] == [0, 1, 1, 2, 1, 2, 2, 3]
    assert bool(catalogs[0]["chosen"]) and catalogs[-1]["chosen"] == ""
    rows = [json.loads(r) for r in Path("ball.actions.jsonl").read_text("utf-8").splitlines()[1:]]
    assert catalogs[-1]["course"]["action"] == [row["action"] for row in rows]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("run", "posture", "--fast"), "--fast is about the page of a run: give --live"),
        (("run", "posture", "--live-port", "0"), "--live-port is about the page"),
        (("learn", "searchtrack", "--out", "a.yaml", "--live-close"), "--live-close is about"),
        (
            ("explore", "searchtrack", "--stage", "x", "--out", "a.yaml", "--live-wait"),
            "--live-wait is about",
        ),
        (("learn", "searchtrack", "--out", "a.yaml", "--live", "--workers", "2"), "--workers 2"),
        (
            ("learn", "searchtrack", "--out", "a.yaml", "--live", "--scheduler", "tcp://x:1"),
            "--scheduler runs them",
        ),
    ],
    ids=str,
)
def test_unsuitable_live_options_print_one_message(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    words: tuple[str, ...],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, *words) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_taken_port_is_one_message_with_a_free_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert cb(monkeypatch, *REACH, *LIVE, "--live-port", str(port)) == 2
    assert re.search(
        rf"--live-port {port}: another program listens there; \d+ is free", capsys.readouterr().err
    )


@pytest.mark.parametrize(("variables", "opened"), [({}, False), ({"DISPLAY": ":0"}, True)], ids=str)
def test_browser_is_opened_only_where_there_is_a_screen(
    monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], opened: bool
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    launched: list[str] = []
    monkeypatch.setattr(module.typer, "launch", launched.append)
    monkeypatch.setattr(module.sys, "platform", "linux")
    monkeypatch.setattr(module.sys.stdout, "isatty", lambda: True, raising=False)
    module._open("http://127.0.0.1:1/")
    assert bool(launched) == opened


@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("during", ["the run", "the stay"])
def test_interrupt_leaves_no_process_and_no_port(name: str, during: str) -> None:
    words = [*REACH[:-1], "--live", *(["--fast"] if during == "the stay" else [])]
    process = subprocess.Popen(
        [sys.executable, "-c", "from cbdsl.cli.main import main; main()", *words],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "DISPLAY": ""},
    )
    assert process.stdout is not None
    mark = "stays until Ctrl-C" if during == "the stay" else "episode with seed"
    port, path = 0, ""
    for line in process.stdout:
        if found := re.search(r"live at http://127\.0\.0\.1:(\d+)(/\S+/)", line):
            port, path = int(found[1]), found[2]
        if mark in line:
            break
    connection = HTTPConnection("127.0.0.1", port, timeout=10)
    connection.request("GET", f"{path}events")
    stream = connection.getresponse()
    assert stream.readline() == b"event: episode\n"
    process.send_signal(getattr(signal, name))
    assert process.wait(20) == (0 if during == "the stay" else 130)
    assert stream.read().endswith(b"event: closed\ndata: {}\n\n")
    with socket.socket() as there:
        assert there.connect_ex(("127.0.0.1", port)) != 0


def test_run_that_returns_to_an_earlier_state_ends_as_before(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *REACH) == 0
    alone, times = capsys.readouterr().out, list[float]()
    note_tick, run_to = LiveView.note_tick, LiveView.run_to

    def returning(view: LiveView, tick: Tick) -> None:
        times.append(tick.observation.time)
        if len(times) == 20:
            view._transport.go_back(0.2)
        note_tick(view, tick)

    def released(view: LiveView, time: float) -> None:
        view._transport.release()  # no page could continue after the pause
        run_to(view, time)

    monkeypatch.setattr(LiveView, "note_tick", returning)
    monkeypatch.setattr(LiveView, "run_to", released)
    assert cb(monkeypatch, *REACH, *LIVE) == 0
    assert outcome(capsys.readouterr().out) == outcome(alone)
    assert times[20:40] == times[:20]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("engine", "cameras"), [("mujoco", "ideal"), ("mujoco", "rendered"), ("bullet", "ideal")]
)
def test_run_that_returns_repeats_all_observations(
    engine: str, cameras: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seen, ticks = list[tuple[object, ...]](), 60
    note_tick, run_to = LiveView.note_tick, LiveView.run_to

    def returning(view: LiveView, tick: Tick) -> None:
        each = tick.observation
        loads = {cell: load.tolist() for cell, load in each.loads.items()}
        images = {camera: zlib.crc32(image.tobytes()) for camera, image in each.images.items()}
        seen.append((each.time, each.positions.tolist(), loads, images or each.regions))
        if len(seen) == ticks:
            view._transport.go_back(each.time)
        if len(seen) == 2 * ticks:
            raise KeyboardInterrupt
        note_tick(view, tick)

    def released(view: LiveView, time: float) -> None:
        view._transport.release()
        run_to(view, time)

    monkeypatch.setattr(LiveView, "note_tick", returning)
    monkeypatch.setattr(LiveView, "run_to", released)
    words = ("run", "pick_and_lift", "--backend", engine, "--cameras", cameras, "--seed", "5")
    cb(monkeypatch, *words, *LIVE)
    assert len(seen) == 2 * ticks
    assert any(row[-1] for row in seen)
    assert seen[ticks:] == seen[:ticks]


def test_page_that_stays_runs_the_seed_again_for_a_return(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = iter([None, 0.1])
    monkeypatch.setattr(LiveView, "run_to", lambda view, time: None)

    def take_return(view: LiveView, patience: float) -> float | None:
        try:
            return next(answers)
        except StopIteration:
            raise KeyboardInterrupt from None

    monkeypatch.setattr(LiveView, "take_return", take_return)
    assert cb(monkeypatch, *REACH, "--live", "--fast") == 0
    first, second = map(outcome, capsys.readouterr().out.splitlines())
    assert first == second
