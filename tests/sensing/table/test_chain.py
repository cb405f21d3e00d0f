"""Chains of casts as rows execute them."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.chain import CastError, carry
from cbdsl.types.casts import CAMERA, CASTS, SIGHTING, Chain
from cbdsl.types.resource import (
    Centroid,
    ConstellationSignal,
    EffectorConfiguration,
    FingerForces,
    FingerLoad,
    GraspCentre,
    Heading,
    Headings,
    LinkDistance,
    MarkHeading,
    NetForces,
    NetLoad,
    NovelHeading,
    Opening,
    PairLikeness,
    Posture,
    Separation,
    SolidSignal,
    StereoOffset,
    StereoPosition,
    Tip,
    Turned,
)
from cbdsl.types.source_record import chains_of
from cbdsl.yaml_text.library import Library
from tests.sensing.vision.signals.test_visual_signals import (
    CHANNEL,
    between,
    facing,
    feel,
    see,
    signals,
)

__all__ = ["signals"]

HEADINGS = [f"{camera}.{CHANNEL}" for camera in ("left", "cyclopean", "cameras")]


# Names of the casts of each chain from which rows of a source compile their Jacobians.
MANIPULATOR, LOAD, TURN = "inverse manipulator Jacobian", "compliance", "turn of a camera"
HELD = ("rigid hold", MANIPULATOR)
BY_CAMERA = ("inverse camera Jacobian",)
EXECUTED: dict[type, set[tuple[str, ...]]] = {
    **{key: {()} for key in (EffectorConfiguration, Posture, Turned)},
    **{key: {(MANIPULATOR,)} for key in (Tip, Centroid, Separation, Opening, GraspCentre)},
    **{key: {(LOAD,)} for key in (FingerLoad, NetLoad, NetForces, FingerForces)},
    **{key: {(TURN,)} for key in (ConstellationSignal, StereoOffset, SolidSignal, PairLikeness)},
    **{key: {BY_CAMERA} for key in (NovelHeading, MarkHeading)},
    LinkDistance: {(MANIPULATOR,)},
    Heading: {BY_CAMERA, ("inverse sighting Jacobian", *HELD)},
    Headings: {BY_CAMERA, ("stereo triangulation", *HELD)},
    StereoPosition: {HELD},
}


@pytest.mark.parametrize("name", ["dexter", "panda", "desk", "sixaxis"])
def test_rows_execute_every_chain_of_every_resource(library: Library, name: str) -> None:
    robot = library.read(library.locate(RobotDocument, name), RobotDocument).document
    for resource in resources(robot).values():
        names = {tuple(cast.name for cast in chain) for chain in chains_of(resource)}
        if not resource.is_drawn:
            assert names == EXECUTED.get(type(resource.source), set()), resource.name


def test_a_chain_that_no_row_executes_is_refused(dexter: RobotDocument, signals: Signals) -> None:
    """Replace the right cast by every other cast of the graph."""
    named = resources(dexter)
    for name in ("right_arm.position", "right_hand.net.force", f"cyclopean.{CHANNEL}"):
        executed = {cast for chain in chains_of(named[name]) for cast in chain[-1:]}
        for cast in CASTS:
            if cast.name not in {each.name for each in executed}:
                with pytest.raises(CastError, match=cast.name):
                    signals.bind(named[name], ((cast,),))


def test_a_chain_is_carried_from_the_joints_to_the_feedback() -> None:
    chain: Chain = (SIGHTING, CAMERA)
    steps = {
        CAMERA.name: lambda joints: ("camera", joints),
        SIGHTING.name: lambda inner: ("sighting", inner),
    }
    assert carry(chain, steps) == ("sighting", ("camera", None))


@pytest.mark.parametrize("name", HEADINGS)
def test_the_chains_of_a_heading_add_up_to_its_jacobian(
    dexter: RobotDocument, signals: Signals, name: str
) -> None:
    """Through the cameras the head moves it, through the hold the arms, and nothing else."""
    feel(dexter, signals, facing(dexter, signals), 0.0)
    feel(dexter, signals, facing(dexter, signals), 5.0)
    see(dexter, signals, between(dexter, signals))
    resource = resources(dexter)[name]
    whole = signals.read(resource)
    assert whole is not None and whole.jacobian is not None
    by_chain = []
    for chain in chains_of(resource):
        part = signals.reading(signals.bind(resource, (chain,)))
        assert part is not None and part.jacobian is not None
        assert np.array_equal(part.value, whole.value)
        by_chain.append(part.jacobian)
    camera, held = by_chain
    assert camera + held == pytest.approx(whole.jacobian)
    head, arms = signals.joints.of("head"), signals.joints.of("arms")
    assert camera[:, head].any() and not np.delete(camera, head, axis=1).any()
    assert held[:, arms].any() and not np.delete(held, arms, axis=1).any()
