"""A network that pushes among obstacles, below guards, bare, and behind the filters of others.

Obstacles have random sizes and places between hand, object and goal. Pushes act on the arm, all
sensors are noisy, and 10 % of the actions of the network are random. All conditions have the same
network and, by seed, the same scenes, pushes and random actions.

Violations are counted in each tick by the truth of the world: contacts of any link with obstacles,
the table and other links, and the net force on the world. Further ones are a palm outside of its
workspace while the network moves it, and joints beyond their limits. The law itself keeps limits of
joints in all conditions. Guards and the filter know the obstacles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from cbdsl import EpisodeResult, RunRequest, UsageError
from cbdsl.api.control import Floats, Kinematics, read_urdf
from cbdsl.api.open_robot import OpenRobot
from cbdsl.extend.backend import Joints, embody
from cbdsl_reproduction.guarded.disturbed_backend import DisturbedBackend
from cbdsl_reproduction.guarded.filters import HIGH, LOW
from cbdsl_reproduction.guarded.program import NETWORK, PROGRAM, PushSetting, request_of
from cbdsl_reproduction.guarded.violations import (
    COLLISIONS,
    KINDS,
    TrueTick,
    TruthBounds,
    Violations,
)
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
    "guarded": PushSetting(is_guarded=True, is_alone=False),
    "guarded without steps": PushSetting(is_guarded=True),
    "bare": PushSetting(),
    "clamped": PushSetting(filter="clamped"),
    "CBF-QP": PushSetting(filter="barrier"),
    "CBF-QP with table": PushSetting(filter="barrier", has_table=True),
    "clean guarded": PushSetting(is_guarded=True, is_alone=False, is_clean=True),
    "clean bare": PushSetting(is_clean=True),
}
_ANY = dict.fromkeys(
    ("success", "success lost", "reported without success", "collision", *KINDS), ANY
)
_SAFE = _ANY | {
    "reported without success": NONE,
    "collision": Aim(most=0.01),
    **{kind: NONE for kind in KINDS if kind not in COLLISIONS},
}
# A success is lost if the bare network has it in the clean scene.
_AIMS = {
    "guarded": _SAFE | {"success": Aim(0.9)},
    "clean guarded": _SAFE | {"success lost": Aim(most=0.02)},
}
_BACKEND = "mujoco"
# Arm that the network moves, and its links that are pushed.
_ARM, _PUSHED = "right_arm", ("right_link_4", "right_link_5", "right_link_6", "right_palm")
# Line that the object has to cross, and the end of its way, y, m.
_LINE, _FARTHEST = -0.1, 0.0


class _EndedPush(NamedTuple):
    """Ended episode: its result, success by truth, and violations."""

    result: EpisodeResult
    succeeded: bool
    violations: Violations

    def verdict(self, usual: float | None) -> EpisodeVerdict:
        """Return the verdict.

        Args:
            usual: Simulated time of the bare network in the clean scene, s; ``None`` if it fails.
        """
        result, violations = self.result, self.violations
        ticks = violations.ticks
        outcomes = {
            "success": self.succeeded,
            "success lost": usual is not None and not self.succeeded,
            "reported without success": result.outcome == "success" and not self.succeeded,
            "collision": any(ticks[kind] for kind in COLLISIONS),
            **{kind: count > 0 for kind, count in ticks.items()},
        }
        measures = {f"{kind.replace(' ', '_')}_ticks": float(ticks[kind]) for kind in KINDS}
        measures["force_n"] = violations.force
        if self.succeeded and usual is not None:
            measures["added_s"] = result.sim_seconds - usual
        touched = ", ".join(sorted(violations.touched))
        ending = f"{result.ending} Touched: {touched}." if touched else result.ending
        return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, ending, measures)


class _Palm:
    """Palm of the arm in truth.

    Args:
        engine: Engine of the world.
        request: Program with its robot.
    """

    def __init__(self, engine: Any, request: RunRequest) -> None:
        tip = request.robot.effectors[_ARM].tip
        assert tip is not None, "the arms of the shipped robot have tips"
        self._engine, self._link, self._offset = engine, tip.link, np.array(tip.offset)

    def while_network(self, tick: Any) -> Floats | None:
        """Return its position, m, shape (3,), or ``None`` unless the network moves it."""
        action = tick.run.action
        if action is None or not set(NETWORK).intersection(action.name.split(" ◁ ")):
            return None
        pose = self._engine.link_pose(self._link)
        position: Floats = pose.position + pose.rotation @ self._offset
        return position


def _run(setting: PushSetting, seed: int, body: BodyChoice) -> _EndedPush:
    """Run an episode in a world of its own.

    Args:
        setting: Setting of the condition.
        seed: Seed of scene, disturbances and random actions.
        body: Backend and cameras.
    """
    with TemporaryDirectory() as folder:
        request = request_of(setting, seed, Path(folder))
        backend: Any = embody(body.backend, request.robot, request.urdf, cameras=body.cameras)
        with closing(backend):
            engine, palm = backend.truth, _Palm(backend.truth, request)
            violations = Violations(_bounds(request), request.stage.things)

            def note(tick: Any) -> None:
                (positions, velocities), contacts = engine.read(), tuple(engine.link_contacts())
                place = palm.while_network(tick)
                violations.note(TrueTick(positions, velocities, place, contacts))

            world = backend if setting.is_clean else DisturbedBackend(backend, _PUSHED)
            robot = OpenRobot(request, world, Kinematics(request.robot, request.urdf))
            result = robot.run(seed, on_tick=note)
            (thing,) = set(engine.names()) - set(request.stage.fixtures)
            last = float(engine.pose(thing).position[1])
    return _EndedPush(result, _LINE < last < _FARTHEST, violations)


def _bounds(request: RunRequest) -> TruthBounds:
    """Return the bounds of joints, workspace and force."""
    model = read_urdf(request.urdf)
    joints = [model.joints[name] for name in Joints(request.robot).names]
    lower, upper, speed = (
        np.array([getattr(joint, key) for joint in joints])
        for key in ("lower", "upper", "velocity")
    )
    return TruthBounds(lower, upper, speed, LOW, HIGH)


@lru_cache(maxsize=2048)
def _usual(seed: int, body: BodyChoice) -> float | None:
    """Return the time of the bare network in the clean scene, s, or ``None`` if it fails."""
    ended = _run(_SETTINGS["clean bare"], seed, body)
    return ended.result.sim_seconds if ended.succeeded else None


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each episode.

    Raises:
        UsageError: A package is missing, or the backend cannot push links.
    """
    setting = _SETTINGS[condition.name]
    if body.backend != _BACKEND:
        raise UsageError("the judge 'guarded' pushes links in MuJoCo; leave out --backend")
    _require_installed()
    for seed in seeds:
        yield _run(setting, seed, body).verdict(_usual(seed, body))


def _require_installed() -> None:
    needed = ("cbdsl_mujoco", "cbdsl_onnx", "onnxruntime")
    if missing := [name for name in needed if find_spec(name) is None]:
        raise UsageError(
            f"the judge 'guarded' needs {' and '.join(missing)}: "
            "pip install 'cbdsl-reproduction[guarded]'"
        )


JUDGE = Judge(
    "guarded",
    "a network that pushes among obstacles: below guards, bare, and behind filters",
    tuple(
        JudgedCondition(name, PROGRAM, _AIMS.get(name, _ANY), "thing_to_push") for name in _SETTINGS
    ),
    _measure,
    BodyChoice(_BACKEND, "ideal"),
    folder="guarded",
)
