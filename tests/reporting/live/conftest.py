"""Episodes in the synthetic world that a live view watches."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from tests.conftest import Checked
from tests.runtime.conftest import made_stage, on_table
from tests.runtime.synthetic import SyntheticBackend

Watched = Callable[..., EpisodeResult]


@pytest.fixture(scope="session")
def watched(checked: Checked, dexter: RobotDocument, urdf: Path, kinematics: Kinematics) -> Watched:
    """Return a function that plays a program for a view, and calls ``each`` every tick."""

    def run(
        view: LiveView,
        name: str = "reachtouch",
        each: Callable[[Tick], Any] = lambda tick: None,
        seed: int = 25,
    ) -> EpisodeResult:
        program = checked(name)
        backend = SyntheticBackend(dexter, urdf, lambda rng: on_table(), lambda world, time: None)
        runner = Runner(dexter, kinematics, program, backend)
        stage = made_stage({})

        def on_tick(tick: Tick) -> None:
            each(tick)
            view.note_tick(tick)

        view.begin(program, stage.name, seed)
        return runner.run(
            stage,
            seed,
            observer=EpisodeListeners(
                on_transition=view.note_transition, on_tick=on_tick, on_end=view.note_end
            ),
        )

    return run
