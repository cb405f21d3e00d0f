"""Success rate of touching with both hands as printed (Section 4.3.3), on a mount of the arms.

``bimanualtouch_printed`` grasps an object with the right hand, and then runs MANIPULABILITY(both
arms) subject to TOUCH(right hand), with TOUCH(left hand). A reward counts if both hands touch the
object at the end, by the engine's contacts. Mounts are rows of ``search_mounts.py``; row 0 is the
current one.

    python benchmarks/mounted_touch.py build/mounts.jsonl --number 0 --episodes 10 --seed 100

A file that ends in .json has one mount with the postures of both arms, as ``opposed_arms.json``.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from arm_mount import ROOT, TODAY, ArmMount
from mounted_arms import MountedArms, mirrored
from search_mounts import read

from cbdsl.backends.backend import embody
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.tick import Tick
from cbdsl.yaml_text.library import Library

PROGRAM = "bimanualtouch_printed"
_TIPS = "left_palm", "right_palm"
_HANDS = {"left_hand", "right_hand"}

#: Postures by arm and name, rad.
Postures = Mapping[str, Mapping[str, Sequence[float]]]


class Episode(NamedTuple):
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
        shutil.copytree(ROOT / part, folder / part)
    shutil.copy(Path(__file__).with_name(f"{PROGRAM}.yaml"), folder / "programs")
    if mount == TODAY:
        return
    library = Library(folder)
    robot_file = library.locate(RobotDocument, "dexter")
    if postures is None:
        postures = _postures_of(library.read(robot_file, RobotDocument).document, mount, turns)
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
    cameras: str,
    seeds: Iterable[int],
    turns: Sequence[float] = (0.0, 0.0),
    postures: Postures | None = None,
) -> list[Episode]:
    """Run the program on successive seeds; see ``write_robot``."""
    with TemporaryDirectory() as folder:
        write_robot(mount, Path(folder), turns, postures)
        library = Library(Path(folder))
        program = check_program(str(Path(folder) / "programs" / f"{PROGRAM}.yaml"), {}, library)
        file = library.locate(RobotDocument, "dexter")
        robot, urdf = library.read(file, RobotDocument).document, file.parent / "dexter.urdf"
        stage_file = library.locate(StageDocument, program.stage or "")
        stage = library.read(stage_file, StageDocument).document
        engine = embody(backend, robot, urdf, cameras=cameras)
        own = Kinematics(robot, urdf)
        runner = Runner(robot, Kinematics(robot, urdf), program, engine)
        done = [_run(runner, engine, own, stage, seed) for seed in seeds]
        engine.close()
    return done


def _run(runner: Runner, engine: Any, own: Kinematics, stage: StageDocument, seed: int) -> Episode:
    apart: list[float] = []
    taken: list[int] = []
    met: list[bool] = []

    def note(tick: Tick) -> None:
        if taken:
            met.append(_hands_on(engine, stage) == _HANDS)
            own.update(tick.signals.positions)
            left, right = (own.frame(tip).position for tip in _TIPS)
            apart.append(float(np.linalg.norm(left - right)))

    def judge(transition: Any) -> None:
        if transition.depth == 0 and transition.next_state.startswith("1"):
            taken.append(transition.depth)

    result = runner.run(stage, seed, observer=EpisodeListeners(on_transition=judge, on_tick=note))
    both = _hands_on(engine, stage) == _HANDS
    return Episode(
        seed, bool(taken), round(min(apart, default=np.nan), 3), any(met), result.rewarded, both,
        result.sim_seconds, result.ending,
    )  # fmt: skip


def _hands_on(engine: Any, stage: StageDocument) -> set[str]:
    """Return the hands that touch an object, by the engine."""
    names = [name for name in engine.truth.objects if name not in stage.fixtures]
    return {hand for name in names for hand, _ in engine.truth.touching(name)}


def summarise(episodes: Sequence[Episode]) -> dict[str, Any]:
    """Return one row of the table."""
    near = [each.apart for each in episodes if each.taken]
    return {
        "episodes": len(episodes),
        "taken": sum(each.taken for each in episodes),
        "median_apart_m": round(float(np.median(near)), 3) if near else None,
        "met": sum(each.met for each in episodes),
        "rewarded": sum(each.rewarded for each in episodes),
        "rewarded_and_both": sum(each.rewarded and each.both for each in episodes),
        "amiss": [(each.seed, each.ending) for each in episodes if not each.rewarded],
    }


def read_mount(file: Path, number: int) -> tuple[ArmMount, Postures | None]:
    """Return a mount, and its postures if they are given with it.

    Args:
        file: Rows of ``search_mounts.py``, or a JSON file of one mount.
        number: Number of the row.
    """
    if file.suffix == ".json":
        given = json.loads(file.read_text(encoding="utf-8"))
        return ArmMount(**given["mount"]), given["postures"]
    row = next(trial for trial in read(file) if trial.number == number)
    return ArmMount(**row.mount), None


def main() -> None:
    """Run the episodes."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("file", type=Path, help="rows of search_mounts.py, or one mount")
    parser.add_argument("--number", type=int, default=0, help="of the mount's row")
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--cameras", choices=("rendered", "ideal"), default="ideal")
    parser.add_argument("--episodes", type=int, default=10)
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument(
        "--turns", type=float, nargs=2, default=(0.0, 0.0), metavar=("LEFT", "RIGHT"),
        help="of the resting hands about their palms' normals, degrees",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    mount, postures = read_mount(options.file, options.number)
    seeds = range(options.seed, options.seed + options.episodes)
    turns = [math.radians(turn) for turn in options.turns]
    row = summarise(run_episodes(mount, options.backend, options.cameras, seeds, turns, postures))
    row = {"number": options.number, "backend": options.backend, **row}
    print(json.dumps(row) if options.json else "  ".join(f"{k} {v}" for k, v in row.items()))


if __name__ == "__main__":
    main()
