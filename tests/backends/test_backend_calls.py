"""Calls of a backend: its own failures and broken answers name it, and are not faults of cbdsl."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.backend_calls import closing_backend
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.sensing.observation import Observation
from tests.conftest import Checked
from tests.runtime.synthetic import SyntheticBackend

METHODS = ("reset", "observe", "apply", "step")
Change = Callable[[Observation], object]


class Faulty(SyntheticBackend):
    """Backend whose methods fail, once a few ticks are over, and that counts its halts."""

    def __init__(self, robot: RobotDocument, urdf: Path, method: str, error: BaseException) -> None:
        super().__init__(robot, urdf)
        self.method, self.error, self.halt_error = method, error, None
        self.change: Change = lambda observation: observation

    def _fail(self, method: str) -> None:
        if method == self.method and (method == "reset" or self._tick > 2):
            raise self.error

    def reset(self, *given: Any) -> Any:
        self._fail("reset")
        return super().reset(*given)

    def observe(self) -> Any:
        self._fail("observe")
        seen = super().observe()
        return self.change(seen) if self._tick > 2 else seen

    def apply(self, reference: Any) -> None:
        self._fail("apply")
        super().apply(reference)

    def step(self) -> None:
        self._fail("step")
        super().step()

    def halt(self) -> None:
        super().halt()
        if self.halt_error is not None:
            raise self.halt_error


@pytest.fixture
def play(
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics, checked: Checked,
    stage: Callable[[str], StageDocument],
) -> Callable[..., tuple[Faulty, BaseException, list[EpisodeResult]]]:  # fmt: skip
    def run(
        method: str = "", error: BaseException | None = None, change: Change | None = None,
        halt_error: BaseException | None = None,
        on_end: Callable[[EpisodeResult], None] | None = None,
    ) -> tuple[Faulty, BaseException, list[EpisodeResult]]:  # fmt: skip
        backend, ended = Faulty(dexter, urdf, method, error or RuntimeError("motor 3")), []
        backend.change, backend.halt_error = change or backend.change, halt_error
        runner = Runner(dexter, kinematics, checked("posture"), backend)
        with pytest.raises(BaseException) as caught:
            runner.run(stage("absent"), 0, observer=EpisodeListeners(on_end=on_end or ended.append))
        return backend, caught.value, ended

    return run


@pytest.mark.parametrize("method", METHODS)
def test_backend_that_raises_is_halted_and_named(method: str, play: Any) -> None:
    backend, error, ended = play(method)
    assert isinstance(error, BackendError)
    assert str(error) == f"backend 'Faulty': {method}() raised RuntimeError: motor 3"
    assert backend.halts == 1
    assert len(ended) == (method != "reset")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("error", [KeyboardInterrupt(), BackendError("no such thing")])
def test_backend_that_is_interrupted_is_halted(
    method: str, error: BaseException, play: Any
) -> None:
    backend, raised, ended = play(method, error)
    assert raised is error and backend.halts == 1
    assert len(ended) == (method != "reset")


@pytest.mark.parametrize("method", METHODS)
def test_halt_that_raises_keeps_the_first_cause_and_the_recording(method: str, play: Any) -> None:
    _, error, ended = play(method, halt_error=OSError("bus off"))
    assert "motor 3" in str(error)
    (note,) = error.__notes__
    assert note == "the robot may still move: backend 'Faulty': halt() raised OSError: bus off"
    assert len(ended) == (method != "reset")


def test_halt_that_is_interrupted_is_called_again(play: Any) -> None:
    backend, error, _ = play("step", halt_error=KeyboardInterrupt())
    assert "motor 3" in str(error) and backend.halts == 2
    assert error.__notes__ == ["the robot may still move: KeyboardInterrupt"]


def test_recording_that_fails_at_the_end_keeps_the_first_cause(play: Any) -> None:
    def full(_: EpisodeResult) -> None:
        raise OSError("disk full")

    _, error, _ = play("step", on_end=full)
    assert "motor 3" in str(error)
    assert error.__notes__ == ["the episode so far is not recorded: disk full"]


def test_closed_episode_whose_halt_raises_reports_it(
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics, checked: Checked,
    stage: Callable[[str], StageDocument],
) -> None:  # fmt: skip
    backend = Faulty(dexter, urdf, "", RuntimeError())
    backend.halt_error = OSError("bus off")
    ticks = Runner(dexter, kinematics, checked("posture"), backend).ticks(stage("absent"), 0)
    next(ticks)
    with pytest.raises(BackendError, match=r"the robot may still move.*bus off"):
        ticks.close()


def test_late_tick_whose_halt_raises_reports_both(
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics, checked: Checked,
    stage: Callable[[str], StageDocument],
) -> None:  # fmt: skip
    backend, ended = Faulty(dexter, urdf, "", RuntimeError()), []
    backend.deadline, backend.halt_error = 0.0, OSError("bus off")
    runner = Runner(dexter, kinematics, checked("posture"), backend)
    with pytest.raises(BaseException, match="a control tick took") as caught:
        runner.run(stage("absent"), 0, observer=EpisodeListeners(on_end=ended.append))
    assert "bus off" in caught.value.__notes__[0] and len(ended) == 1


CHANGES: dict[str, Change] = {
    "the time nan": lambda seen: replace(seen, time=float("nan")),
    "the time inf": lambda seen: replace(seen, time=float("inf")),
    "the time None": lambda seen: replace(seen, time=None),
    "the time 0 s after": lambda seen: replace(seen, time=0.0),
    "the time nan of its images": lambda seen: replace(seen, exposed=float("nan")),
    "positions as float64 of shape (3,)": lambda seen: replace(seen, positions=np.zeros(3)),
    "positions as a list": lambda seen: replace(seen, positions=list(seen.positions)),
    "velocities as float32": lambda seen: replace(seen, velocities=np.float32(seen.velocities)),
    "efforts as float64 of shape (1,)": lambda seen: replace(seen, efforts=np.zeros(1)),
    "loads as a list": lambda seen: replace(seen, loads=[]),
    "as float64 of shape (3,), not as floats of shape (6,)": lambda seen: replace(
        seen, loads={cell: np.zeros(3) for cell in seen.loads}
    ),
    "image of 'rear'": lambda seen: replace(seen, images={"rear": np.zeros((4, 4, 3), np.uint8)}),
    "not as bytes": lambda seen: replace(seen, images={"left": np.zeros((4, 4))}),
    "returned a NoneType": lambda seen: None,
}


@pytest.mark.parametrize("words", CHANGES)
def test_observation_that_breaks_the_contract_names_the_backend(words: str, play: Any) -> None:
    backend, error, ended = play(change=CHANGES[words])
    assert isinstance(error, BackendError) and str(error).startswith("backend 'Faulty': observe()")
    assert words in str(error)
    assert backend.halts == 1 and len(ended) == 1


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan"), float("inf"), None, "fast"])
def test_backend_without_a_control_period_is_refused(
    period: Any, dexter: RobotDocument, urdf: Path, kinematics: Kinematics, checked: Checked
) -> None:
    backend = SyntheticBackend(dexter, urdf)
    backend.control_period = period
    with pytest.raises(BackendError, match="control period"):
        Runner(dexter, kinematics, checked("posture"), backend)


def test_embody_that_raises_names_the_backend(
    dexter: RobotDocument, urdf: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from cbdsl.backends.backend import embody

    def fail(*_: Any, **__: Any) -> None:
        raise OSError("no device /dev/ttyUSB0")

    monkeypatch.setattr(KinematicBackend, "__init__", fail)
    with pytest.raises(BackendError, match=r"backend 'kinematic' .*no device /dev/ttyUSB0"):
        embody("kinematic", dexter, urdf)


def test_closing_backend_that_raises_keeps_the_first_cause(
    dexter: RobotDocument, urdf: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail() -> None:
        raise OSError("bus off")

    backend = SyntheticBackend(dexter, urdf)
    monkeypatch.setattr(backend, "close", fail)
    with pytest.raises(KeyError) as caught, closing_backend(backend):
        raise KeyError("first")
    assert caught.value.__notes__ == ["backend 'SyntheticBackend' cannot be closed: bus off"]
    with pytest.raises(BackendError, match="cannot be closed: bus off"), closing_backend(backend):
        pass
