"""Public robot models on every engine with physics: models that run, and reasons of refusals.

Sixty URDFs come from the packages ``pybullet_data``, part of PyBullet, and ``example-robot-data``
(``pip install --no-deps example-robot-data``). Each gets the robot file proposed by ``cb new
robot``. It holds its posture for a second, and then moves each joint by a tenth of a radian or a
centimetre. A model runs if it is not refused and all its positions stay finite. Each engine has the
share of joints that arrive within 0.02 rad or m. The exit status is 1 if a model runs on the first
engine and not on another.

    python benchmarks/public_models.py [--only panda,ur] [--json]
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import time
from collections.abc import Iterator
from contextlib import redirect_stdout
from importlib.metadata import PackageNotFoundError, files
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from queue import Empty
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from cbdsl.documents.robot import RobotDocument

ENGINES = ("bullet", "mujoco")
# Time limit of one model on all engines, s.
PATIENCE = 120.0
# Displacement and tolerance of joint references, rad or m.
TURN, SLIDE, NEAR = 0.1, 0.01, 0.02

# Folders and files below, by package.
MODELS = {
    "pybullet_data": """
        a1/a1 aliengo/aliengo biped/biped2d_pybullet cartpole differential/diff_ring
        franka_panda/panda gripper/wsg50_one_motor_gripper_left_finger humanoid/humanoid husky/husky
        kuka_iiwa/model kuka_iiwa/model_vr_limits laikago/laikago_toes mini_cheetah/mini_cheetah
        pendulum5 pr2_gripper quadruped/minitaur quadruped/spirit40 quadruped/vision60 r2d2
        racecar/racecar samurai TwoJointRobot_w_fixedJoints xarm/xarm6_robot
        xarm/xarm6_with_gripper
    """,
    "example-robot-data": """
        alex_description/urdf/alex_nub_hands allegro_hand_description/urdf/allegro_right_hand
        anymal_b_simple_description/robots/anymal anymal_b_simple_description/robots/anymal-kinova
        anymal_c_simple_description/urdf/anymal asr_twodof_description/urdf/TwoDofs
        b1_description/urdf/b1-z1 baxter_description/urdf/baxter bolt_description/robots/bolt
        borinot_description/urdf/borinot_flying_arm_2 centauro_description/urdf/centauro
        double_pendulum_description/urdf/double_pendulum finger_edu_description/robots/finger_edu
        g1_description/urdf/g1_29dof_rev_1_0 go1_description/urdf/go1 go2_description/urdf/go2
        hyq_description/robots/hyq_no_sensors icub_description/robots/icub
        icub_description/robots/icub_reduced kinova_description/robots/kinova
        panda_description/urdf/panda panda_description/urdf/panda_collision
        pr2_description/urdf/pr2 romeo_description/urdf/romeo_small
        simple_humanoid_description/urdf/simple_humanoid so_arm_description/urdf/so101
        solo_description/robots/solo12 talos_data/robots/talos_full_v2
        talos_data/robots/talos_reduced tiago_description/robots/tiago
        tiago_pro_description/robots/tiago_pro ur_description/urdf/ur3_gripper
        ur_description/urdf/ur5_robot ur_description/urdf/ur10_robot
        xarm_description/urdf/xarm7 z1_description/urdf/z1
    """,
}


def folder_of(package: str) -> Path | None:
    """Return the folder of a package's models, if it is installed."""
    if package == "pybullet_data":
        found = find_spec(package)
        return Path(found.origin).parent if found and found.origin else None
    try:
        first = next(each for each in files(package) or [] if each.suffix == ".urdf")
    except (PackageNotFoundError, StopIteration):
        return None
    path = Path(str(first.locate()))
    return next(
        each for each in path.parents if each.name == "robots" and each.parent.name == package
    )


def models() -> Iterator[tuple[str, Path | None]]:
    """Yield all models by name, with their files if the package is installed."""
    for package, names in MODELS.items():
        folder = folder_of(package)
        for name in names.split():
            yield f"{package}: {name}", folder and folder / f"{name}.urdf"


def moved(urdf: Path, engine: str) -> dict[str, Any]:
    """Hold and move a robot on an engine, in this process."""
    from cbdsl.backends.backend import embody
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.stage import StageDocument
    from cbdsl.robot.joints import Joints
    from cbdsl.robot.urdf import UrdfError
    from cbdsl.robot.urdf_reader import read_urdf

    head = {"cbdsl": 1, "kind": "stage", "name": "empty", "robot": "public"}
    stage = StageDocument.model_validate({**head, "contexts": {"empty": {}}})
    began = time.process_time()
    try:
        model, robot = read_urdf(urdf), proposed(urdf)
        backend = embody(engine, robot, urdf)
        backend.reset(stage, None, np.random.default_rng(0))
    except (UsageError, UrdfError) as error:
        return {"runs": False, "why": str(error).replace(f"{urdf.parent}/", "")}
    limits = [model.joints[name] for name in Joints(robot).names]
    steps = np.array([SLIDE if each.slides else TURN for each in limits])
    start = backend.observe().positions
    upper = np.array([each.upper for each in limits])
    # A joint at its upper limit moves the other way.
    target = start + np.where(start + steps > upper, -steps, steps)
    for reference in (start, target):
        for _ in range(round(1 / backend.control_period)):
            backend.apply(reference)
            backend.step()
    positions = backend.observe().positions
    finite = bool(np.isfinite(positions).all())
    near = np.abs(positions - target) < NEAR
    return {
        "runs": finite,
        "why": "" if finite else "positions that are no numbers",
        "joints": len(steps),
        "arrived": int(near.sum()),
        "seconds": round(time.process_time() - began, 2),
    }


def proposed(urdf: Path) -> RobotDocument:
    """Return the robot file that ``cb new robot`` writes for a model.

    Raises:
        UsageError: It writes no robot file, or one with errors.
    """
    import typer

    from cbdsl.cli.new import new_robot
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.yaml_text.library import Library

    with TemporaryDirectory() as place, redirect_stdout(StringIO()) as said:
        try:
            new_robot("public", urdf, to=Path(place))
        except typer.Exit as end:
            if end.exit_code == 1:
                first = next((line for line in said.getvalue().splitlines() if "error" in line), "")
                raise UsageError(f"its robot file has errors: {first}") from None
        return Library(Path(place)).read(Path(place) / "public.yaml", RobotDocument).document


def _answer(urdf: Path, engine: str, answers: Any) -> None:
    # The output of the simulators and of the proposal is discarded.
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    answers.put(moved(urdf, engine))


def tried(urdf: Path, engine: str) -> dict[str, Any]:
    """Run the same in a process of its own, which an engine may end."""
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    process = context.Process(target=_answer, args=(urdf, engine, answers))
    process.start()
    outcome: dict[str, Any] = {"runs": False, "why": "its process ended"}
    # An engine that crashes ends its process without an answer, which polling notices early.
    ends = time.monotonic() + PATIENCE
    while time.monotonic() < ends:
        try:
            outcome = answers.get(timeout=0.2)
            break
        except Empty:
            if not process.is_alive():
                break
    else:
        outcome["why"] = f"no answer in {PATIENCE:g} s"
    process.kill()
    process.join()
    return outcome


def main() -> None:
    """Try all models, and print a line for each and one for all of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help="parts of names, separated by commas")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    import cbdsl_mujoco.engine  # noqa: F401 - once, before processes are made of this one

    wanted = options.only.split(",") if options.only else [""]
    rows = []
    for name, file in models():
        if not any(part in name for part in wanted):
            continue
        if file is None or not file.exists():
            sys.exit(f"{name} is not there; pip install --no-deps {name.partition(':')[0]}")
        row: dict[str, Any] = {"model": name, **{engine: tried(file, engine) for engine in ENGINES}}
        rows.append(row)
        print(json.dumps(row) if options.json else _line(row), flush=True)
    first, *others = ENGINES
    counts = {engine: sum(row[engine]["runs"] for row in rows) for engine in ENGINES}
    lost = [
        row["model"] for row in rows for each in others if row[first]["runs"] > row[each]["runs"]
    ]
    print(json.dumps({"models": len(rows), **counts, "only_on_the_first": lost}))
    sys.exit(bool(lost))


def _line(row: dict[str, Any]) -> str:
    parts = []
    for engine in ENGINES:
        one = row[engine]
        told = f"{one['arrived']} of {one['joints']} joints" if one["runs"] else one["why"]
        parts.append(f"{engine}: {told}")
    return f"{row['model']:<60} {'   '.join(parts)}"


if __name__ == "__main__":
    main()
