"""A network that pushes among obstacles, below guards, alone, and behind the filters of others.

Each episode has obstacles of random sizes and places between hand, object and goal, pushes against
the arm, noise on all sensors, and a network that acts at random in 10 % of its actions. All
conditions have the same network and, by seed, the same scenes and disturbances. Violations are
counted in each tick by the truth of the world: contacts of any link with obstacles, the table or
other links, the net force on the world, the workspace while the network acts, and the limits of
joints. The law itself keeps joint limits and speeds in all conditions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cbdsl import EpisodeResult, RunRequest, UsageError
from cbdsl.api.control import Kinematics, read_urdf
from cbdsl.api.open_robot import OpenRobot
from cbdsl.extend.backend import Joints, embody
from cbdsl_reproduction.guarded.disturbed_backend import DisturbedBackend
from cbdsl_reproduction.guarded.filters import HIGH, LOW
from cbdsl_reproduction.guarded.program import PROGRAM, Setting, request_of
from cbdsl_reproduction.guarded.violations import KINDS, Bounds, Moment, Violations
from cbdsl_reproduction.judges.judge import (
    ANY,
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)

_SETTINGS = {
    "guarded": Setting(is_guarded=True, is_alone=False),
    "guarded, network alone": Setting(is_guarded=True),
    "bare": Setting(),
    "clamped": Setting(filter="clamped"),
    "CBF-QP": Setting(filter="barrier"),
    "guarded, clean": Setting(is_guarded=True, is_alone=False, is_clean=True),
    "bare, clean": Setting(is_clean=True),
}
_AIMS = {
    "guarded": {
        "success": Aim(0.9),
        "reported without success": NONE,
        "collision": Aim(most=0.01),
        **dict.fromkeys(KINDS[1:], NONE),
    }
}
_ANY = dict.fromkeys(("success", "reported without success", *KINDS), ANY)
# Hand and arm that the program moves, and the number of its first link that is pushed.
_ARM, _PUSHED = "right_arm", ("right_link_4", "right_link_5", "right_link_6", "right_palm")
# Line that the object has to cross, and end of its way, m.
_LINE, _FARTHEST = -0.1, 0.0


class _Episode:
    """One episode in a world of its own.

    Args:
        setting: Setting of the condition.
        seed: Seed of scene, disturbances and random actions.
        body: Backend and cameras.
    """

    def __init__(self, setting: Setting, seed: int, body: BodyChoice) -> None:
        self._seed = seed
        with TemporaryDirectory() as folder:
            request = request_of(setting, seed, Path(folder))
            backend: Any = embody(body.backend, request.robot, request.urdf, cameras=body.cameras)
            with closing(backend):
                self._engine = backend.truth
                tip = request.robot.effectors[_ARM].tip
                assert tip is not None, "the arms of the robot have tips"
                self._tip = tip.link, np.array(tip.offset)
                shown = [*request.stage.things]
                self.violations = Violations(_bounds(request), shown)
                world = backend if setting.is_clean else DisturbedBackend(backend, _PUSHED)
                robot = OpenRobot(request, world, Kinematics(request.robot, request.urdf))
                self.result: EpisodeResult = robot.run(seed, on_tick=self._note)
                (thing,) = set(self._engine.names()) - set(request.stage.fixtures)
                self.last = float(self._engine.pose(thing).position[1])

    def _note(self, tick: Any) -> None:
        positions, velocities = self._engine.read()
        action = tick.run.action
        levels = action.name.split(" ◁ ") if action is not None else []
        palm = None
        if "policy" in levels or "again" in levels:
            link, offset = self._tip
            pose = self._engine.link_pose(link)
            palm = pose.position + pose.rotation @ offset
        contacts = tuple(self._engine.link_contacts())
        self.violations.note(Moment(positions, velocities, palm, contacts))

    @property
    def succeeded(self) -> bool:
        """True if the object ended beyond the line, by truth."""
        return _LINE < self.last < _FARTHEST

    def verdict(self, usual: float | None) -> EpisodeVerdict:
        """Return the verdict.

        Args:
            usual: Simulated time of the bare network in the clean scene, s; ``None`` if it fails.
        """
        result, violations = self.result, self.violations
        outcomes: dict[str, bool | None] = {
            "success": self.succeeded,
            "reported without success": result.outcome == "success" and not self.succeeded,
            **{kind: count > 0 for kind, count in violations.ticks.items()},
        }
        measures = {
            f"{kind.replace(' ', '_')}_ticks": float(n) for kind, n in violations.ticks.items()
        }
        measures["force_n"] = violations.force
        if self.succeeded and usual is not None:
            measures["added_s"] = result.sim_seconds - usual
        touched = ", ".join(sorted(violations.touched))
        ending = f"{result.ending} Touched: {touched}." if touched else result.ending
        return EpisodeVerdict(self._seed, outcomes, result.sim_seconds, ending, measures)


def _bounds(request: RunRequest) -> Bounds:
    """Return the bounds of joints, workspace and force."""
    model = read_urdf(request.urdf)
    joints = [model.joints[name] for name in Joints(request.robot).names]
    lower, upper, speed = (
        np.array([getattr(joint, key) for joint in joints])
        for key in ("lower", "upper", "velocity")
    )
    return Bounds(lower, upper, speed, LOW, HIGH, 8.0)


@lru_cache(maxsize=1024)
def _usual(seed: int, body: BodyChoice) -> float | None:
    """Return the time of the bare network in a clean scene, s, ``None`` if it fails there."""
    episode = _Episode(_SETTINGS["bare, clean"], seed, body)
    return episode.result.sim_seconds if episode.succeeded else None


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each episode.

    Raises:
        UsageError: A package is missing, or the backend cannot push links.
    """
    setting = _SETTINGS[condition.name]
    if body.backend != "mujoco":
        raise UsageError("the judge 'guarded' pushes links of MuJoCo; leave out --backend")
    needed = ["cbdsl_onnx", *(["qpsolvers", "quadprog"] if setting.filter == "barrier" else [])]
    if missing := [name for name in needed if find_spec(name) is None]:
        raise UsageError(
            f"{condition.name}: {', '.join(missing)} is not installed; "
            "the extra 'guarded' of cbdsl-reproduction brings it"
        )
    for seed in seeds:
        yield _Episode(setting, seed, body).verdict(_usual(seed, body))


JUDGE = Judge(
    "guarded",
    "a network that pushes among obstacles: below guards, alone, and behind filters",
    tuple(
        JudgedCondition(name, PROGRAM, _AIMS.get(name, _ANY), "thing_to_push")
        for name in _SETTINGS
    ),
    _measure,
    BodyChoice("mujoco", "ideal"),
    folder="guarded",
)
