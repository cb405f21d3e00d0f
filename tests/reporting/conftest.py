"""Recordings of episodes in the synthetic world."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.staging.world_state import Part
from cbdsl.documents.robot import RobotDocument
from cbdsl.reporting.automaton_text import automata
from cbdsl.reporting.recorded import Recorded, read_recording
from cbdsl.runtime.recording import Recording
from cbdsl.runtime.tick import Tick
from tests.conftest import Checked
from tests.runtime.conftest import TABLE_BALL, Play, play

__all__ = ["play"]

Record = Callable[..., Path]


class Shown:
    """Scene of recordings: the ball on the table."""

    def names(self) -> tuple[str, ...]:
        return ("ball",)

    def parts(self, name: str) -> list[Part]:
        return [Part("ball", (0.07,), (0, 0, 0), (0, 0, 0, 1), (1, 0, 0))]

    def pose(self, name: str) -> Shown:
        return self

    @property
    def position(self) -> np.ndarray:
        return TABLE_BALL

    def quaternion(self) -> tuple[float, float, float, float]:
        return (0.0, 0.0, 0.0, 1.0)


@pytest.fixture(scope="session")
def record(
    checked: Checked,
    play: Play,
    dexter: RobotDocument,
    urdf: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> Record:
    """Return a function that plays and records a program, and returns the recording's JSON file."""

    def run(name: str = "reachtouch", **more: object) -> Path:
        program = checked(name)
        recording = Recording(program, dexter, urdf, Shown, automata=automata(program))

        def watch(tick: Tick) -> None:
            recording.note_tick(tick)

        played = play(program, watch=watch, **more)
        for transition in played.transitions:
            recording.note_transition(transition)
        return recording.write(tmp_path_factory.mktemp("kept"), played.result)

    return run


@pytest.fixture(scope="session")
def kept(record: Record) -> Path:
    """Record a rewarded reachtouch."""
    return record()


@pytest.fixture(scope="session")
def recorded(kept: Path) -> Recorded:
    return read_recording(kept)
