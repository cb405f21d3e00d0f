"""Beginning of an episode: its context and its posture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.shape import draw
from cbdsl.documents.context import Context
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.joints import Joints


class EpisodeStart(NamedTuple):
    """Draws with which each episode begins, on any robot.

    Attributes:
        context: Name of the context.
        noise: Generator of the sensors' noise.
        posture: Start positions of the actuated joints, rad or m, shape (n,).
    """

    context: str
    noise: np.random.Generator
    posture: Floats


def draw_start(
    stage: StageDocument,
    context: str | None,
    robot: RobotDocument,
    joints: Joints,
    elsewhere: Floats,
    rng: np.random.Generator,
) -> EpisodeStart:
    """Draw the beginning of an episode; see ``choose_context`` and ``starting_posture``.

    Raises:
        BackendError: The stage has no such context, or the robot lacks a joint of it.
    """
    name = choose_context(stage, context, rng)
    # The sensors' noise has its own stream, so that other draws from rng cannot change it.
    noise = np.random.default_rng(rng.integers(2**63))
    posture = starting_posture(stage.contexts[name], robot, joints, elsewhere, rng)
    return EpisodeStart(name, noise, posture)


def choose_context(stage: StageDocument, context: str | None, rng: np.random.Generator) -> str:
    """Return the name of the context, drawn by the shares of all if it is ``None``.

    Raises:
        BackendError: The stage has no such context.
    """
    if context is None:
        shares = np.array([each.share for each in stage.contexts.values()])
        return list(stage.contexts)[int(rng.choice(len(shares), p=shares / shares.sum()))]
    if context not in stage.contexts:
        known = ", ".join(stage.contexts)
        raise BackendError(f"stage '{stage.name}' has no context '{context}'; it has: {known}")
    return context


def starting_posture(
    context: Context,
    robot: RobotDocument,
    joints: Joints,
    elsewhere: Floats,
    rng: np.random.Generator,
) -> Floats:
    """Return the start positions of the actuated joints, rad, shape (n,).

    Args:
        context: Context, whose joint positions have priority.
        robot: Robot document, whose start postures of effectors come next.
        joints: Order of the joints.
        elsewhere: Positions of joints that neither specifies, rad, shape (n,).
        rng: Generator of positions that the context leaves to chance.

    Raises:
        BackendError: The context names a joint that the robot does not have.
    """
    unknown = set(context.joints) - set(joints.names)
    if unknown:
        raise BackendError(
            f"robot '{robot.name}' has no actuated joint " + ", ".join(map(repr, sorted(unknown)))
        )
    # Order of precedence, lowest first: elsewhere, start postures, the context's joints.
    start: Floats = elsewhere.copy()
    for name, posture in robot.start_postures.items():
        start[joints.of(name)] = posture
    for joint, span in context.joints.items():
        start[joints.index[joint]] = draw(span, rng)
    return start
