"""A backend of another package: found by its name, listed, and run on."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cbdsl.backends.backend import BACKENDS
from tests.cli.test_main import cb
from tests.plugins.installed import write_package


def test_program_runs_on_a_plugin_backend(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, "run", "posture", "--backend", "ideal") == 0
    assert "Done after" in capsys.readouterr().out


def test_plugin_backend_is_listed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "backends", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    summary = "Joints without errors; see ``cbdsl.extend.backend.Backend``."
    assert {"backend": "ideal", "package": "demo 1.0", "summary": summary} in shown
    names = [each["backend"] for each in shown]
    assert names == [*BACKENDS.builtins, "follower", "ideal", "mujoco", "ros2"]


def test_broken_plugin_backend_is_named_and_others_work(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_package(folder, "odd", {BACKENDS.group: {"odd": "builtins:dict"}})
    BACKENDS.refresh()
    assert cb(monkeypatch, "show", "backends") == 0
    out, err = capsys.readouterr()
    assert "ideal" in out and "odd" not in out
    assert "backend 'odd' (package odd 1.0, group cbdsl.backends): lacks the methods reset" in err


def test_unplugged_robot_ends_the_run_with_its_cause(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from demo.follower import Follower

    calls: list[str] = []
    read, leave = Follower.get_observation, Follower.disconnect

    def unplugged(robot: Follower) -> dict[str, float]:
        calls.append("get_observation")
        if len(calls) > 30:
            raise ConnectionError("no status packet from motor 3")
        values: dict[str, float] = read(robot)
        return values

    def noted(robot: Follower) -> None:
        calls.append("disconnect")
        leave(robot)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Follower, "get_observation", unplugged)
    monkeypatch.setattr(Follower, "disconnect", noted)
    assert cb(monkeypatch, "run", "poise", "--robot", "sixaxis", "--backend", "follower") == 2
    fault = "Follower.get_observation failed: ConnectionError: no status packet from motor 3"
    error = capsys.readouterr().err
    assert fault in error and "Traceback" not in error
    assert calls[-1] == "disconnect" and calls.count("disconnect") == 1
