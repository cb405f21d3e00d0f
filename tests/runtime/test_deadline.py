"""A late tick ends its episode, and every early end halts the backend."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.cli.main import main
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import DeadlineError, EpisodeError, Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.observation import Observation
from tests.conftest import Checked
from tests.runtime.synthetic import SyntheticBackend, World


class TimedBackend(SyntheticBackend):
    """A backend with a clock: each tick takes as long as a test says, s."""

    deadline = 0.02

    def __init__(self, robot: RobotDocument, urdf: Path, slow: int, taken: float) -> None:
        super().__init__(robot, urdf)
        self._slow, self._taken, self._now = slow, taken, 0.0

    def clock(self) -> float:
        return self._now

    def observe(self) -> Observation:
        self._now += self._taken if self._tick == self._slow else 0.01
        return super().observe()

    def step(self) -> None:
        self._now += 1.0  # the world's time is not the controllers'
        super().step()


Make = Callable[[SyntheticBackend], Runner]


@pytest.fixture
def runner(
    dexter: RobotDocument, kinematics: Kinematics, checked: Checked
) -> Callable[[SyntheticBackend], Runner]:
    def make(backend: SyntheticBackend) -> Runner:
        clock = {"clock": backend.clock} if isinstance(backend, TimedBackend) else {}
        return Runner(dexter, kinematics, checked("posture"), backend, **clock)

    return make


@pytest.fixture
def absent(stage: Callable[[str], StageDocument]) -> StageDocument:
    return stage("absent")


def test_late_tick_halts_the_backend_and_ends_the_episode(
    runner: Make, absent: StageDocument, dexter: RobotDocument, urdf: Path
) -> None:
    backend = TimedBackend(dexter, urdf, slow=6, taken=0.025)
    with pytest.raises(DeadlineError) as caught:
        runner(backend).run(absent, 0)
    result = caught.value.result
    assert backend.halts == 1
    assert len(backend.applied) == result.ticks == 6, "what is late is not applied"
    assert not result.rewarded
    assert result.ending == (
        "Halted after 0.1 s in state 0: a control tick took 25 ms, and the backend's deadline is "
        "20 ms; references are frozen at the measured positions."
    )


def test_ticks_in_time_and_a_late_last_one_do_not_matter(
    runner: Make, absent: StageDocument, dexter: RobotDocument, urdf: Path
) -> None:
    backend = TimedBackend(dexter, urdf, slow=-1, taken=0.0)
    result = runner(backend).run(absent, 0)
    assert backend.halts == 0 and result.ticks > 10
    again = TimedBackend(dexter, urdf, slow=result.ticks, taken=9.0)
    assert runner(again).run(absent, 0).ending == result.ending


@pytest.mark.parametrize("deadline", [None, 0.02])
def test_signals_know_whether_the_world_waits(
    runner: Make, absent: StageDocument, dexter: RobotDocument, urdf: Path, deadline: float | None
) -> None:
    backend = TimedBackend(dexter, urdf, slow=-1, taken=0.0)
    backend.deadline = deadline  # type: ignore[assignment]
    seen: set[bool] = set()
    note = EpisodeListeners(on_tick=lambda tick: seen.add(tick.signals.is_awaited))
    runner(backend).run(absent, 0, observer=note)
    assert seen == {deadline is None}


def _interrupt(tick: Tick) -> None:
    if tick.observation.time > 0.1:
        raise KeyboardInterrupt


def test_ctrl_c_halts_the_backend(
    runner: Make, absent: StageDocument, dexter: RobotDocument, urdf: Path
) -> None:
    backend = SyntheticBackend(dexter, urdf)
    ended: list[EpisodeResult] = []
    with pytest.raises(KeyboardInterrupt):
        runner(backend).run(
            absent, 0, observer=EpisodeListeners(on_tick=_interrupt, on_end=ended.append)
        )
    assert backend.halts == 1
    (result,) = ended
    assert result.ending == "Interrupted after 0.1 s in state 0."
    assert result.ticks == len(backend.applied)


def test_broken_sensor_halts_the_backend(
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    checked: Checked,
    stage: Callable[[str], StageDocument],
) -> None:
    broken = {("right_hand", "finger_1"): np.full(6, np.nan)}
    backend = SyntheticBackend(dexter, urdf, begin=lambda rng: World(broken=broken))
    ended: list[EpisodeResult] = []
    broken_runner = Runner(dexter, kinematics, checked("reachtouch"), backend)
    with pytest.raises(EpisodeError):
        broken_runner.run(stage("absent"), 0, observer=EpisodeListeners(on_end=ended.append))
    assert backend.halts == 1
    assert ended[0].ending.startswith("Failed after 0.0 s in state ")
    assert "finger_1" in ended[0].ending


def test_command_ends_as_for_an_episode_that_cannot_go_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(KinematicBackend, "deadline", 0.0)
    monkeypatch.setattr("sys.argv", ["cb", "run", "posture", "--backend", "kinematic", "--json"])
    with pytest.raises(SystemExit) as end:
        main()
    told = capsys.readouterr()
    assert end.value.code == 2
    assert "deadline is 0 ms" in json.loads(told.out)["ending"]
    assert "seed 0: Halted after 0.0 s" in told.err and "Traceback" not in told.err
