"""Pads beside the origins of their links, and pads that one joint drives."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.types.source_record import Normals
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

# Places of the pads in the frames of the fingers that carry them, m.
PADS = {"left": (0.0, 0.0, 0.045), "right": (0.0, 0.0, 0.045)}
CHANNEL = "hue_1"


@pytest.fixture(scope="module")
def panda(library: Library) -> RobotDocument:
    return library.read(library.locate(RobotDocument, "panda"), RobotDocument).document


@pytest.fixture(scope="module")
def beside(panda: RobotDocument) -> RobotDocument:
    """Return a Panda whose load cells are on the fingers, away from their origins."""
    cells = {
        name: cell.model_copy(update={"link": cell.link.removesuffix("_pad"), "pad": PADS[name]})
        for name, cell in panda.load_cells["hand"].items()
    }
    return panda.model_copy(update={"load_cells": {"hand": cells}})


def signals_of(robot: RobotDocument) -> Signals:
    return Signals(
        robot, Kinematics(robot, ROOT / "robots" / robot.model), resources(robot).values()
    )


def tick(signals: Signals, *forces: float, slant: float = 0.0, turn: float = 0.0) -> None:
    """Update a tick in which the pads press along their normals, N, with a share of friction."""
    positions = np.linspace(-0.3, 0.3, len(signals.joints))
    positions[1] += turn
    positions[-1] = 0.03
    signals.kinematics.update(positions)
    loads = {}
    for cell, force in zip(signals.touch.cells, forces, strict=True):
        own = signals.robot.load_cells[cell[0]][cell[1]]
        frame = signals.kinematics.frame(own.link)
        pushed = force * frame.rotation @ (np.array(own.normal) + np.array([0.0, 0.0, slant]))
        lever = frame.rotation @ np.array(own.pad)
        loads[cell] = np.concatenate([pushed, np.cross(lever, pushed)])
    signals.update(Observation(0.0, positions, np.zeros_like(positions), loads, {}))


@pytest.mark.parametrize("name", ["hand.centre", "hand.opening"])
def test_pad_beside_the_origin_of_its_link_is_read_as_one_there(
    panda: RobotDocument, beside: RobotDocument, name: str
) -> None:
    readings = []
    for robot in (panda, beside):
        signals = signals_of(robot)
        tick(signals, 0.0, 0.0)
        readings.append(signals.read(resources(robot)[name]))
    one, other = readings
    assert one is not None
    assert other is not None
    assert other.value == pytest.approx(one.value, abs=1e-9)
    assert other.jacobian == pytest.approx(one.jacobian, abs=1e-9)


def test_pads_press_where_they_are_beside_the_origins_of_their_links(
    panda: RobotDocument, beside: RobotDocument
) -> None:
    """Compare the places at which a search decides whether it has found its object."""
    parts = [signals_of(robot).touch.pads("hand")[0] for robot in (panda, beside)]
    for one, other in zip(*parts, strict=True):
        assert other.origin == pytest.approx(one.origin)
        assert other.normal == pytest.approx(one.normal)


@pytest.mark.parametrize("away", [0.0, 0.2])
def test_object_between_pads_beside_their_links_is_held_under_friction(
    beside: RobotDocument, away: float
) -> None:
    signals = signals_of(beside)
    tick(signals, 0.0, 0.0)
    centre = signals.read(resources(beside)["hand.centre"])
    assert centre is not None
    place = centre.value + np.array([0.0, 0.0, away])
    memory = signals.vision.memories[CHANNEL]
    memory.position, memory.radius = place, 0.02
    tick(signals, 5.0, 5.0, slant=1.0)
    tick(signals, 5.0, 5.0, slant=1.0, turn=0.1)
    moved = float(np.linalg.norm(memory.position - place))
    assert (moved > 0.01) == (away == 0.0)


def test_pads_that_one_joint_drives_feel_their_mean(panda: RobotDocument) -> None:
    signals = signals_of(panda)
    tick(signals, 0.0, 0.0)
    tick(signals, 3.0, 1.0)
    number = signals._bind_normal_forces(Normals.FINGERS, "hand")
    signals.refresh(signals.select([number]))
    assert signals.table.values(number) == pytest.approx([2.0, 2.0], abs=1e-6)
