"""Guard of distances: the motion that parts links keeps within the law's bounds."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from cbdsl.control.distance_guard import hold_back
from cbdsl.control.law import Law, LawSettings, Step
from cbdsl.control.law_arrays import LawArrays
from cbdsl.control.stack import Stack
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.link_clearance import LinkClearance
from cbdsl.kinematics.link_distance import DistanceArrays
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once
from cbdsl.numeric.handle import Handle, hold
from cbdsl.robot.urdf_reader import read_urdf

STEP, ROOM = 0.02, 0.01  # rad


class Arrays(NamedTuple):
    distances: DistanceArrays
    law: LawArrays


@compiled_once
def held_back(arrays: Handle, before: Floats, references: Floats, parting: Floats) -> None:
    held: Arrays = arrays.held
    columns = np.arange(len(before))
    hold_back(held.distances, before, references, columns, parting, held.law)


@pytest.mark.parametrize("length", [0.005, 0.5])
def test_parting_motion_keeps_within_steps_and_limits(
    dexter: RobotDocument, urdf: Path, length: float
) -> None:
    links = LinkClearance(dexter, read_urdf(urdf), least=0.02, near=0.3)
    before = links.start
    links.measure(before)
    nearest = int(np.argmin(links.arrays.pairs["distance"]))
    slope = links.slope(nearest)
    slope /= np.abs(slope).max()
    pairs = links.arrays.pairs[[nearest]]
    pairs["before"] = pairs["distance"]
    distances = links.arrays._replace(pairs=pairs)
    distances.bounds[0] = 1.0  # m, so that the pair is too near
    bounds = before - ROOM, before + ROOM
    law = Law(*bounds, LawSettings(STEP, limit_margin=0.0))
    step = Step.of(Stack([("c", 1)], len(before)))
    arrays = hold(Arrays(distances, law.arrays(step)))
    references = before - ROOM * slope
    held_back(arrays, before, references, length * slope)
    moved = np.abs(references - before)
    assert 0.0 < moved.max() <= ROOM + 1e-12
    links.arrays.at[:] = np.nan
    links.measure(references)
    assert links.arrays.pairs["distance"][nearest] > pairs["before"][0]
