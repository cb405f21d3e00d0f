"""Recordings: everything is kept, and half a file is never visible."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.staging.world_state import Part
from cbdsl.documents.robot import RobotDocument
from cbdsl.program.checked import resources_of
from cbdsl.reporting.page import page
from cbdsl.reporting.recorded import read_recording
from cbdsl.runtime.causes import LIMITS, OPTIMUM, SINGULAR
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.explanation import Explanation
from cbdsl.runtime.recording import Recording, is_place, members, triple
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.table.reading import Reading
from cbdsl.types.resource import Origin
from tests.conftest import Checked
from tests.runtime.conftest import Play, Played


@pytest.fixture(scope="module")
def recorded(
    checked: Checked, play: Play, dexter: RobotDocument, urdf: Path
) -> tuple[Played, Recording]:
    program = checked("searchtrack")
    recording = Recording(program, dexter, urdf)
    played = play(program, watch=recording.note_tick, seed=4)
    for transition in played.transitions:
        recording.note_transition(transition)
    return played, recording


def test_recording_holds_the_observations_of_the_episode(
    recorded: tuple[Played, Recording], tmp_path: Path
) -> None:
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
    checked: Checked, play: Play, dexter: RobotDocument, urdf: Path, tmp_path: Path
) -> None:
    program = checked("reachtouch")
    resources = [each for each in resources_of(program) if each.origin is not Origin.MODEL]
    read: list[dict[str, Reading | None]] = []

    def watch(tick: Tick) -> None:
        read.append({each.name: tick.signals.read(each) for each in resources})
        recording.note_tick(tick)

    recording = Recording(program, dexter, urdf)
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


def test_recorded_levels_equal_the_explanation(
    checked: Checked, play: Play, dexter: RobotDocument, urdf: Path, tmp_path: Path
) -> None:
    program = checked("reachtouch")
    recording, explanation = Recording(program, dexter, urdf), Explanation()
    told = []

    def watch(tick: Tick) -> None:
        told.append(explanation.note(tick))
        recording.note_tick(tick)

    played = play(program, watch=watch)
    file = recording.write(tmp_path, played.result)
    summary = json.loads(file.read_text("utf-8"))
    assert summary["cbdsl"] == 1
    names, joints = summary["controllers"], summary["joints"]
    holders = ["", *names, LIMITS, OPTIMUM, SINGULAR]
    with np.load(file.with_suffix(".npz")) as arrays:
        kept = {key: arrays[key] for key in arrays}
    for index, tick in enumerate(told):
        acting = np.flatnonzero(kept["level_priority"][index] >= 0)
        order = acting[np.argsort(kept["level_priority"][index, acting])]
        assert [names[column] for column in order] == [level.name for level in tick.levels]
        for column, level in zip(order, tick.levels, strict=True):
            assert kept["level_share"][index, column] == pytest.approx(level.share, nan_ok=True)
            assert kept["level_rank"][index, column] == level.rank
            assert kept["level_singular_value"][index, column] == pytest.approx(
                level.singular_value
            )
            assert kept["level_predicted"][index, column] == pytest.approx(
                level.predicted, nan_ok=True
            )
            assert holders[kept["level_held_by"][index, column] + 1] == level.held_by
        for absent in np.flatnonzero(kept["level_priority"][index] < 0):
            assert kept["level_priority"][index, absent] == -1
            assert kept["level_held_by"][index, absent] == -1
            assert kept["level_rank"][index, absent] == 0
            for number in ("share", "singular_value", "predicted"):
                assert np.isnan(kept[f"level_{number}"][index, absent])
        assert [joints[column] for column in np.flatnonzero(kept["at_limits"][index])] == [
            joint for joint in joints if joint in tick.at_limits
        ]
    assert any(level.held_by for tick in told for level in tick.levels)


class _Fair:
    """A ball that rolls, and is taken away after a while."""

    def __init__(self) -> None:
        self.time = 0

    def names(self) -> tuple[str, ...]:
        return ("ball",) if self.time < 3 else ()

    def parts(self, name: str) -> list[Part]:
        return [Part("ball", (0.1,), (0, 0, 0), (0, 0, 0, 1), (1, 0, 0))]

    def pose(self, name: str) -> _Fair:
        return self

    @property
    def position(self) -> np.ndarray:
        return np.array([0.1 * self.time, 0.0, 0.0])

    def quaternion(self) -> tuple[float, float, float, float]:
        return (0.0, 0.0, 0.0, 1.0)


def test_scene_holds_objects_while_they_exist(
    checked: Checked, play: Play, dexter: RobotDocument, urdf: Path, tmp_path: Path
) -> None:
    program, fair = checked("searchtrack"), _Fair()
    recording = Recording(program, dexter, urdf, lambda: fair)

    def watch(tick: Tick) -> None:
        recording.note_tick(tick)
        fair.time += 1

    played = play(program, watch=watch)
    file = recording.write(tmp_path, played.result)
    (part,) = json.loads(file.read_text("utf-8"))["scene"]["ball"]
    assert part["shape"] == "ball" and part["size"] == [0.1]
    with np.load(file.with_suffix(".npz")) as arrays:
        scene = arrays["scene"][:, 0]
    assert scene[:3, 0] == pytest.approx([0.0, 0.1, 0.2])
    assert np.isnan(scene[3:]).all() and len(scene) == played.result.ticks + 1


def test_failed_write_keeps_the_existing_recording(
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


def test_recording_is_readable_by_other_users(
    recorded: tuple[Played, Recording], tmp_path: Path
) -> None:
    played, recording = recorded
    plain = tmp_path / "plain"
    plain.touch()
    for file in (recording.write(tmp_path, played.result), tmp_path / "episode_4.npz"):
        assert file.stat().st_mode == plain.stat().st_mode


@pytest.mark.parametrize("interrupted", ["_note_levels", "_note_scene"])
def test_interrupted_tick_is_not_recorded(
    interrupted: str,
    checked: Checked,
    play: Play,
    dexter: RobotDocument,
    urdf: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = checked("searchtrack")
    recording, calls = Recording(program, dexter, urdf), 0
    noted = getattr(recording, interrupted)

    def interrupt(*given: Tick) -> None:
        nonlocal calls
        calls += 1
        if calls == 4:
            raise KeyboardInterrupt
        noted(*given)

    monkeypatch.setattr(recording, interrupted, interrupt)
    ended: list[EpisodeResult] = []
    with pytest.raises(KeyboardInterrupt):
        play(program, watch=recording.note_tick, on_end=ended.append)
    recorded = read_recording(recording.write(tmp_path, ended[0]))
    assert recording.ticks == 3 == len(recorded.arrays["time"])
    assert len(recorded.arrays["image_time"]) == len(recorded.arrays["image_left"]) <= 3
    assert recorded.summary["result"]["ending"].startswith("Interrupted after 0.1 s in state ")
    assert page(recorded)


def test_controller_is_written_as_its_typed_triple(checked: Checked) -> None:
    told = {
        each.name: triple(each)
        for name in ("searchtrack", "reachtouch", "visualinspect", "twist")
        for action in checked(name).actions
        for each in (action.composition.controllers if action.composition else ())
    }
    assert told["search"] == {
        "potential": "spring", "feedback": "head", "reference": "head.uniform",
        "effector": "head", "unit": "rad", "base": "head.uniform", "requires": "",
    }  # fmt: skip
    shown = {name: (row["reference"], row["unit"]) for name, row in told.items()}
    assert shown["orient"] == ("3.14159, 0, 0", "rad")
    assert shown["touch"] == ("2 N along normals", "N")
    assert shown["sink"] == ("here + -0, -0, -0.009", "m")
    assert shown["resolve"] == ("", "rad")


def test_members_are_those_of_all_programs_that_are_used(checked: Checked) -> None:
    assert members(checked("visualinspect")) == {
        "visualinspect": ("reachtouch", "localizability", "track"),
        "reachtouch": ("searchtrack", "reach", "touch"),
        "searchtrack": ("search", "track"),
    }


def test_places_are_positions_in_the_world(checked: Checked) -> None:
    places = {each.name for each in resources_of(checked("reachtouch")) if is_place(each)}
    assert places == {"right_arm.position", "stereo.sat_10"}


def test_summary_names_the_columns_of_its_arrays(
    recorded: tuple[Played, Recording], dexter: RobotDocument, urdf: Path, tmp_path: Path
) -> None:
    played, recording = recorded
    summary = json.loads(recording.write(tmp_path, played.result).read_text("utf-8"))
    assert (summary["kind"], summary["version"]) == ("recording", 2)
    assert summary["controllers"] == ["search", "track"]
    assert summary["load_cells"] == [
        f"{hand}.{finger}" for hand, cells in dexter.load_cells.items() for finger in cells
    ]
    assert summary["signals"] == {
        "head": {"type": "configuration[2]", "place": False, "channels": []},
        "cyclopean.sat_10": {"type": "heading", "place": False, "channels": ["sat_10"]},
    }
    assert summary["channels"] == ["sat_10"]
    assert summary["leads"] == {"search": "search", "track": "track"}
    assert summary["limits"]["searchtrack"]["transitions"] == 100
    robot = summary["robot"]
    assert robot["urdf"] == urdf.read_text("utf-8")
    assert (robot["name"], robot["folder"]) == ("dexter", str(urdf.parent.resolve()))
    assert robot["couplings"] == {
        name: [each.follows, each.ratio] for name, each in dexter.couplings.items()
    }
    # In a tick as long as the robot's own, its guard is the robot's own.
    assert robot["singular_value"] == pytest.approx(dexter.control.singular_value)
