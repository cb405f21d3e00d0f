"""Materials of links that several surfaces of a robot file name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pybullet as p
import pytest

from cbdsl.backends.staging.links import link_surfaces
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.simulation_section import TipSurface
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl_mujoco.robot_spec import body_name
from tests.backends.conftest import BACKENDS, URDF, sightless, stage_named


def of_bullet(truth: Any, link: str) -> float:
    row = p.getDynamicsInfo(truth.robot.id, truth.robot.links[link], physicsClientId=truth.client)
    friction: float = row[1]
    return friction


def of_mujoco(truth: Any, link: str) -> float:
    model = truth._world.model
    return float(model.geom_friction[model.body(body_name(link)).geomadr[0]][0])


def of_kinematic(truth: Any, link: str) -> float:
    tips = [tip for hand in truth._hands.hands.values() for tip in hand.fingertips]
    return next(tip.friction for tip in tips if tip.link == link)


FRICTION: dict[str, Callable[[Any, str], float]] = {
    "bullet": of_bullet,
    "mujoco": of_mujoco,
    "kinematic": of_kinematic,
}


def with_surfaces(robot: RobotDocument, *surfaces: TipSurface) -> RobotDocument:
    simulation = robot.simulation.model_copy(update={"surfaces": surfaces})
    return robot.model_copy(update={"simulation": simulation})


@pytest.mark.parametrize("engine", BACKENDS)
@pytest.mark.parametrize("is_general_first", [True, False])
def test_link_of_two_surfaces_has_the_friction_of_the_last(
    is_general_first: bool, engine: str, dexter: RobotDocument
) -> None:
    cells = dexter.load_cells["right_hand"].values()
    one, other = (cell.link for cell in list(cells)[:2])
    general = TipSurface(links=("right_finger_*",), friction=0.9, stiffness=3000, damping=60)
    special = TipSurface(links=(one,), friction=0.3)
    order = (general, special) if is_general_first else (special, general)
    robot = with_surfaces(sightless(dexter), *order)
    backend = BACKENDS[engine](robot, URDF)
    backend.reset(stage_named("table_right"), None, np.random.default_rng(0))
    frictions = [FRICTION[engine](backend.truth, link) for link in (one, other)]
    backend.close()
    assert frictions == pytest.approx([0.3 if is_general_first else 0.9, 0.9])


def test_link_surfaces_gives_each_link_one_surface_in_the_written_order(
    dexter: RobotDocument,
) -> None:
    model = read_urdf(URDF)
    soft = TipSurface(links=("right_finger_*", "left_finger_*"), friction=1, stiffness=3000)
    hard = TipSurface(links=("left_finger_*", "left_palm"), friction=0.2)
    found = link_surfaces(with_surfaces(dexter, soft, hard), model)
    assert {link for link, each in found.items() if each is hard} == {
        link for link in model.links if link.startswith("left_finger_")
    } | {"left_palm"}
    assert {link for link, each in found.items() if each is soft} == {
        link for link in model.links if link.startswith("right_finger_")
    }
