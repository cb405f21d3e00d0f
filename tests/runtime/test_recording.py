"""Recordings: everything is kept, and nobody ever sees half a file."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from cbdsl.robot.kinematics import Kinematics
from cbdsl.robot.reading import Reading
from cbdsl.runtime.episode import Tick, resources_of
from cbdsl.runtime.recording import Recording, require_writable
from cbdsl.types.resource import Origin
from tests.conftest import Checked
from tests.runtime.conftest import Play, Played


@pytest.fixture(scope="module")
def recorded(checked: Checked, play: Play, kinematics: Kinematics) -> tuple[Played, Recording]:
    program = checked("searchtrack")
    recording = Recording(kinematics.joints.names, resources_of(program))
    played = play(program, watch=recording.note_tick, seed=4)
    for transition in played.transitions:
        recording.note_transition(transition)
    return played, recording


def test_what_was_kept_is_what_happened(recorded: tuple[Played, Recording], tmp_path: Path) -> None:
    played, recording = recorded
    file = recording.write(tmp_path / "deep" / "down", played.result)
    assert file.name == "episode_4.json"
    summary = json.loads(file.read_text("utf-8"))
    result = summary["result"]
    assert result["ending"] == played.result.ending
    assert tuple(result["predicates"]) == played.result.predicates
    assert [row["next_state"] for row in summary["transitions"]] == [
        each.next_state for each in played.transitions
    ]
    with np.load(file.with_suffix(".npz")) as arrays:
        ticks = played.result.ticks + 1
        sensed = np.array([each.positions for each in played.observations])
        assert np.array_equal(arrays["positions"], sensed)
        assert np.array_equal(arrays["references"][:-1], np.array(played.backend.applied))
        assert arrays["potentials"].shape == (ticks, len(summary["controllers"]))
        assert arrays["loads"].shape == (ticks, len(summary["load_cells"]), 6)
        assert len(summary["predicates"]) == ticks
        images = [each for each in played.observations if each.images]
        assert np.array_equal(arrays["image_time"], [each.time for each in images])
        assert arrays["image_left"].shape == (len(images), 120, 160, 3)
        # The ball is seen on the thumbnails too.
        assert (arrays["image_left"][..., 0] > 200).any()


def test_signals_are_kept_and_undefined_ones_are_nan(
    checked: Checked, play: Play, kinematics: Kinematics, tmp_path: Path
) -> None:
    program = checked("reachtouch")
    resources = [each for each in resources_of(program) if each.origin is not Origin.MODEL]
    read: list[dict[str, Reading | None]] = []

    def watch(tick: Tick) -> None:
        read.append({each.name: tick.signals.read(each) for each in resources})
        recording.note_tick(tick)

    recording = Recording(kinematics.joints.names, resources_of(program))
    played = play(program, watch=watch)
    file = recording.write(tmp_path, played.result)
    with np.load(file.with_suffix(".npz")) as arrays:
        kept = {key.removeprefix("signal_") for key in arrays if key.startswith("signal_")}
        assert kept == {each.name for each in resources}
        for name in kept:
            column = arrays[f"signal_{name}"]
            assert len(column) == len(read)
            for value, reading in zip(column, (row[name] for row in read), strict=True):
                if reading is None:
                    assert np.isnan(value).all()
                else:
                    assert np.array_equal(value, reading.value)
        forces = arrays["signal_right_hand.finger_forces"]
        assert np.isnan(forces[0]).all() and np.isfinite(forces[-1]).all()


def test_a_failed_write_leaves_what_was_there(
    recorded: tuple[Played, Recording], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    played, recording = recorded
    recording.write(tmp_path, played.result)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def fail(*args: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        recording.write(tmp_path, played.result)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_others_may_read_it(recorded: tuple[Played, Recording], tmp_path: Path) -> None:
    played, recording = recorded
    plain = tmp_path / "plain"
    plain.touch()
    for file in (recording.write(tmp_path, played.result), tmp_path / "episode_4.npz"):
        assert file.stat().st_mode == plain.stat().st_mode


def test_a_folder_that_cannot_be_written_is_told_beforehand(tmp_path: Path) -> None:
    require_writable(tmp_path / "new")
    assert not list((tmp_path / "new").iterdir())
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(OSError):
            require_writable(folder)
