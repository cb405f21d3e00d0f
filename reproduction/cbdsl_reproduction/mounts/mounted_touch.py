"""Touching with both hands as printed (Section 4.3.3), on a mount of the arms.

``bimanualtouch_printed`` grasps an object with the right hand, and then runs MANIPULABILITY(both
arms) subject to TOUCH(right hand), with TOUCH(left hand).
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

import cbdsl
from cbdsl.api.control import Kinematics
from cbdsl.api.documents import RobotDocument
from cbdsl.api.sensing import Tick
from cbdsl.api.shipped import shipped_folder, shipped_robot
from cbdsl_reproduction.mounts.arm_mount import TODAY, ArmMount
from cbdsl_reproduction.mounts.mounted_arms import MountedArms, mirrored

PROGRAM = "bimanualtouch_printed"
_TIPS = "left_palm", "right_palm"
_HANDS = {"left_hand", "right_hand"}

#: Postures by arm and name, rad.
Postures = Mapping[str, Mapping[str, Sequence[float]]]


class TouchEpisode(NamedTuple):
    """Episode with one object.

    Attributes:
        seed: Seed of the episode.
        taken: True if the right hand was rewarded for taking it.
        apart: Least distance of the palms after that, m.
        met: True if both hands touched it in the same tick.
        rewarded: True if the left hand was rewarded.
        both: True if both hands touched it at the end.
        seconds: Simulated time.
        ending: Ending of the program.
    """

    seed: int
    taken: bool
    apart: float
    met: bool
    rewarded: bool
    both: bool
    seconds: float
    ending: str


def write_robot(
    mount: ArmMount,
    folder: Path,
    turns: Sequence[float] = (0.0, 0.0),
    postures: Postures | None = None,
) -> None:
    """Write Dexter with its arms on a mount, and the documents that run on it.

    Args:
        mount: Mount of the arms.
        folder: Folder to write to.
        turns: Turns of the resting left and right hand about their palms' normals, rad.
        postures: Postures of the arms, instead of those found for the mount.
    """
    for part in ("robots", "programs", "knowledge"):
        shutil.copytree(shipped_folder() / part, folder / part)
    shutil.copy(Path(__file__).with_name(f"{PROGRAM}.yaml"), folder / "programs")
    if mount == TODAY:
        return
    robot_file = folder / "robots" / "dexter.yaml"
    if postures is None:
        postures = _postures_of(shipped_robot("dexter")[0], mount, turns)
    text = robot_file.read_text(encoding="utf-8")
    for arm, named in postures.items():
        for name, posture in named.items():
            text = with_posture(text, arm, name, posture)
    robot_file.write_text(text, encoding="utf-8")
    (folder / "robots" / "dexter.urdf").write_text(mount.urdf(), encoding="utf-8")


def _postures_of(robot: RobotDocument, mount: ArmMount, turns: Sequence[float]) -> Postures:
    """Return the postures that ``MountedArms`` finds for a mount."""
    arms = MountedArms(robot, mount)
    postures: dict[str, dict[str, Sequence[float]]] = {}
    for side, turn in zip(("left", "right"), turns, strict=True):
        own = postures[f"{side}_arm"] = {}
        for name, right in (("home", arms.rests), ("ready", arms.ready)):
            posture = right.copy() if side == "right" else mirrored(right, arms.limits)
            posture[-1] += turn
            own[name] = posture.tolist()
    return postures


def with_posture(text: str, arm: str, name: str, posture: Sequence[float]) -> str:
    """Return the text of a robot file with another posture of an arm."""
    angles = ", ".join(f"{angle:.4f}" for angle in posture)
    pattern = rf"(  {arm}:\n(?:    .*\n)*?      {name}: )\[[^\]]*\]"
    changed, count = re.subn(pattern, rf"\g<1>[{angles}]", text, count=1)
    if not count:
        raise ValueError(f"{arm} has no posture {name}")
    return changed


def run_episodes(
    mount: ArmMount,
    backend: str,
    cameras: str | None,
    seeds: Iterable[int],
    turns: Sequence[float] = (0.0, 0.0),
    postures: Postures | None = None,
) -> Iterator[TouchEpisode]:
    """Run the program on some seeds; see ``write_robot``."""
    with TemporaryDirectory() as folder:
        write_robot(mount, Path(folder), turns, postures)
        file = Path(folder) / "programs" / f"{PROGRAM}.yaml"
        request = cbdsl.load(file, folder=Path(folder))
        with cbdsl.simulate(request, backend=backend, cameras=cameras) as simulated:
            own = Kinematics(request.robot, request.urdf)
            for seed in seeds:
                yield _run(simulated, own, seed)


def _run(simulated: cbdsl.SimulatedRobot, own: Kinematics, seed: int) -> TouchEpisode:
    apart: list[float] = []
    taken: list[int] = []
    met: list[bool] = []

    def note(tick: Tick) -> None:
        if taken:
            met.append(_hands_on(simulated) == _HANDS)
            own.update(tick.signals.positions)
            left, right = (own.frame(tip).position for tip in _TIPS)
            apart.append(float(np.linalg.norm(left - right)))

    def hear(transition: cbdsl.Transition) -> None:
        if transition.depth == 0 and transition.next_state.startswith("1"):
            taken.append(transition.depth)

    result = simulated.robot.run(seed, on_transition=hear, on_tick=note)
    both = _hands_on(simulated) == _HANDS
    return TouchEpisode(
        seed, bool(taken), round(min(apart, default=np.nan), 3), any(met), result.rewarded, both,
        result.sim_seconds, result.ending,
    )  # fmt: skip


def _hands_on(simulated: cbdsl.SimulatedRobot) -> set[str]:
    """Return the hands that touch an object."""
    truth, fixtures = simulated.truth, simulated.robot.request.stage.fixtures
    names = [name for name in truth.objects if name not in fixtures]
    return {hand for name in names for hand, _ in truth.touching(name)}


def read_opposed() -> tuple[ArmMount, Postures]:
    """Return the mount with palms opposite each other, and the postures of its arms."""
    file = Path(__file__).with_name("opposed_arms.json")
    given: Mapping[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return ArmMount(**given["mount"]), given["postures"]
