"""Loads of an observation by cell."""

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.observation import Loads
from cbdsl.sensing.table.tips import Tips
from cbdsl.sensing.touch.touch import Touch

CELLS = (("left_hand", "thumb"), ("right_hand", "thumb"))
WRENCHES = np.arange(12.0).reshape(2, 6)


def test_loads_are_a_mapping_from_cells_to_wrenches() -> None:
    loads = Loads(CELLS, WRENCHES)
    assert list(loads) == list(CELLS)
    assert len(loads) == 2
    assert [wrench.tolist() for wrench in loads.values()] == WRENCHES.tolist()
    with pytest.raises(KeyError):
        loads["left_hand", "palm"]


def test_loads_are_gathered_in_the_order_of_the_robots_document(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    cells = tuple(
        (hand, finger) for hand, fingers in dexter.load_cells.items() for finger in fingers
    )
    touch = Touch(dexter, kinematics, Tips(dexter, kinematics))
    wrenches = np.random.default_rng(0).normal(size=(len(cells), 6))
    for loads in (
        Loads(cells, wrenches),
        Loads(cells[::-1], wrenches[::-1]),
        dict(zip(cells, wrenches, strict=True)),
    ):
        assert (touch.gathered(loads) == wrenches).all()
