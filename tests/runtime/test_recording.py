"""Recordings: everything is kept, and nobody ever sees half a file."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from cbdsl.runtime.episode import Tick
from cbdsl.runtime.recording import Recording, require_writable
from tests.conftest import Checked
from tests.runtime.conftest import Play, Played


@pytest.fixture(scope="module")
def recorded(checked: Checked, play: Play) -> tuple[Played, Recording]:
    recording: list[Recording] = []

    def watch(tick: Tick) -> None:
        if not recording:
            recording.append(Recording(tick.actuation._signals.joints.names))
        recording[0].note_tick(tick)

    played = play(checked("searchtrack"), watch=watch, seed=4)
    for transition in played.transitions:
        recording[0].note_transition(transition)
    return played, recording[0]


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
