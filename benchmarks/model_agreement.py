"""Poses of the links of public robot models, compared with those of Pinocchio.

Each URDF below the given folders gets the robot file proposed by ``cb new robot``. In random
postures, the pose of each link is compared with that of Pinocchio, which moves mimic joints itself.
Compared are the robot's kinematics, the tree of the engine ``kinematic``, and the models of the
engines ``mujoco`` and ``bullet``. Prints the largest difference of each, in m and in entries of
rotation matrices, and the reason if a model is refused. The exit status is 1 if links differ.

    python benchmarks/model_agreement.py FOLDER... [--postures 5] [--json]
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import Empty
from typing import TYPE_CHECKING, Any

import numpy as np
from public_models import proposed

from cbdsl.numeric.arrays import Floats

if TYPE_CHECKING:
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.robot.urdf import UrdfModel

Placements = dict[str, Floats]
Placing = Callable[[Floats], Placements]

# Largest difference: rounding, and of MuJoCo quaternions, and single precision of PyBullet.
TOLERANCES = {"kinematics": 1e-9, "tree": 1e-9, "mujoco": 1e-6, "bullet": 1e-4}
PATIENCE = 180.0


def placement(rotation: Floats, position: Floats) -> Floats:
    """Return a rotation (3, 3) and a position (3,), m, as one array, shape (3, 4)."""
    return np.column_stack((rotation, position))


def by_pinocchio(robot: RobotDocument, model: UrdfModel) -> Placing:
    """Return Pinocchio's placements, in which mimicking joints follow others."""
    import pinocchio  # noqa: TID251 (the judge, not the robot)

    from cbdsl.robot.joints import Joints

    try:
        reference = pinocchio.buildModelFromUrdf(str(model.path), mimic=True)
    except ValueError:  # a joint precedes the joint that it mimics
        reference = pinocchio.buildModelFromUrdf(str(model.path))
    data, names = reference.createData(), Joints(robot).names
    frames = {link: reference.getFrameId(link, pinocchio.FrameType.BODY) for link in model.links}

    def place(posture: Floats) -> Placements:
        q = pinocchio.neutral(reference)
        given = dict(zip(names, posture.tolist(), strict=True))
        for name, rest in model.rests.items():
            joint = reference.joints[reference.getJointId(name)]
            value, mimic = given.get(name, rest), model.joints[name].mimic
            if mimic is not None and mimic.joint in given:
                value = mimic.ratio * given[mimic.joint] + mimic.offset
            # A joint that mimics another has no coordinate of its own, where that is known.
            if joint.nq:
                turn = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
                q[joint.idx_q : joint.idx_q + joint.nq] = turn
        pinocchio.framesForwardKinematics(reference, data, q)
        poses = {link: data.oMf[frame] for link, frame in frames.items()}
        return {link: placement(pose.rotation, pose.translation) for link, pose in poses.items()}

    return place


def by_kinematics(robot: RobotDocument, model: UrdfModel) -> Placing:
    """Return placements of the robot's kinematics."""
    from cbdsl.kinematics.kinematics import Kinematics

    kinematics = Kinematics(robot, model.path)

    def place(posture: Floats) -> Placements:
        kinematics.update(posture)
        frames = {link: kinematics.frame(link) for link in model.links}
        return {link: placement(each.rotation, each.position) for link, each in frames.items()}

    return place


def by_tree(robot: RobotDocument, model: UrdfModel) -> Placing:
    """Return placements of the engine ``kinematic``."""
    from cbdsl.kinematics.link_tree import LinkTree
    from cbdsl.robot.joints import Joints

    tree = LinkTree(model, Joints(robot), robot.base)

    def place(posture: Floats) -> Placements:
        tree.update(posture)
        poses = {link: tree.pose(link) for link in tree.rows}
        return {link: placement(each.rotation, each.position) for link, each in poses.items()}

    return place


def by_mujoco(robot: RobotDocument, model: UrdfModel) -> Placing:
    """Return placements of the engine ``mujoco``."""
    import mujoco  # noqa: TID251 (the judge, not the robot)

    from cbdsl.robot.joints import Joints
    from cbdsl_mujoco.robot_spec import body_name, compile_spec, make_robot_spec

    joints = Joints(robot)
    compiled = compile_spec(make_robot_spec(robot, model, 0.004), model)
    data = mujoco.MjData(compiled)
    rows = [int(compiled.joint(name).qposadr[0]) for name in joints.all]
    bodies = {link: data.body(body_name(link)) for link in model.links}

    def place(posture: Floats) -> Placements:
        data.qpos[rows] = joints.expand(posture)
        mujoco.mj_forward(compiled, data)
        return {
            link: placement(each.xmat.reshape(3, 3), each.xpos) for link, each in bodies.items()
        }

    return place


def by_bullet(robot: RobotDocument, model: UrdfModel) -> Placing:
    """Return placements of the engine ``bullet``."""
    import pybullet  # noqa: TID251 (the judge, not the robot)

    from cbdsl.backends.bullet.articulation import BulletRobot

    body = BulletRobot(pybullet.connect(pybullet.DIRECT), robot, model, 1 / 240)

    def place(posture: Floats) -> Placements:
        body.place(posture)
        rows = body.placements()
        return {
            link: placement(rows[number + 1, :9].reshape(3, 3), rows[number + 1, 9:])
            for link, number in body.links.items()
        }

    return place


READERS = {
    "kinematics": by_kinematics,
    "tree": by_tree,
    "mujoco": by_mujoco,
    "bullet": by_bullet,
}


def compare(urdf: Path, postures: int) -> dict[str, Any]:
    """Compare the placements of all links of a model, in this process."""
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.robot.joints import Joints
    from cbdsl.robot.urdf import UrdfError
    from cbdsl.robot.urdf_reader import read_urdf

    try:
        model = read_urdf(urdf)
        robot = proposed(urdf)
    except (UsageError, UrdfError) as error:
        return {"why": str(error).replace(f"{urdf.parent}/", "")}
    limits = [model.joints[name] for name in Joints(robot).names]
    # Joints without limits, or with wider ones, are drawn from one turn.
    lower = np.array([max(each.lower, -np.pi) for each in limits])
    upper = np.array([min(each.upper, np.pi) for each in limits])
    rng = np.random.default_rng(0)
    drawn = [rng.uniform(lower, upper) for _ in range(postures)]
    place = by_pinocchio(robot, model)
    expected = [place(posture) for posture in drawn]
    row: dict[str, Any] = {"links": len(model.links), "joints": len(limits)}
    for name, reader in READERS.items():
        try:
            place = reader(robot, model)
        except UsageError as error:
            row[name] = str(error).replace(f"{urdf.parent}/", "")
            continue
        worst, where = 0.0, ""
        for posture, placed in zip(drawn, expected, strict=True):
            for link, pose in place(posture).items():
                apart = float(np.abs(pose - placed[link]).max())
                worst, where = max((worst, where), (apart, link))
        row[name] = worst
        if worst > TOLERANCES[name]:
            row[f"{name}_link"] = where
    return row


def _answer(urdf: Path, postures: int, answers: Any) -> None:
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    try:
        answers.put(compare(urdf, postures))
    # A child without an answer would only be noticed after ``PATIENCE``.
    except BaseException as error:
        answers.put({"why": f"{type(error).__name__}: {error}", "internal": True})


def compared(urdf: Path, postures: int) -> dict[str, Any]:
    """Compare a model in a process of its own, which an engine may end."""
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    process = context.Process(target=_answer, args=(urdf, postures, answers))
    process.start()
    outcome: dict[str, Any] = {"why": f"no answer in {PATIENCE:g} s", "internal": True}
    with suppress(Empty):
        outcome = answers.get(timeout=PATIENCE)
    process.kill()
    process.join()
    return outcome


def main() -> None:
    """Compare all models below some folders, and print a line for each and one for all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--postures", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    import cbdsl_mujoco.engine  # noqa: F401 - once, before processes are made of this one

    rows = []
    for folder in options.folders:
        for file in sorted(folder.rglob("*.urdf")):
            row = {"model": str(file.relative_to(folder)), **compared(file, options.postures)}
            rows.append(row)
            print(json.dumps(row) if options.json else _line(row), flush=True)
    counts = {name: sum(isinstance(row.get(name), float) for row in rows) for name in READERS}
    apart = [row["model"] for row in rows if any(f"{name}_link" in row for name in READERS)]
    failed = [row["model"] for row in rows if row.get("internal")]
    summary = {"models": len(rows), "compared": counts, "apart": apart, "failed": failed}
    print(json.dumps(summary))
    sys.exit(bool(apart or failed))


def _line(row: dict[str, Any]) -> str:
    told = row.get("why") or "  ".join(
        f"{name} {row[name]:.0e}" if isinstance(row[name], float) else f"{name}: {row[name]}"
        for name in READERS
    )
    return f"{row['model']:<70} {told}"


if __name__ == "__main__":
    main()
