"""What the ideal cameras report."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.channels import Region
from tests.backends.conftest import URDF, stage_named

Reported = Mapping[str, Mapping[str, Region]]


def _reported(backend: KinematicBackend, channels: Collection[str] | None) -> list[Reported]:
    """The regions of an episode's first images."""
    stage = stage_named("moving_right")
    backend.reset(stage, None, np.random.default_rng(1), channels)
    found = []
    for _ in range(20):
        found.append(backend.observe().regions)
        backend.step()
    return found


@pytest.fixture(scope="module")
def backend(dexter: RobotDocument) -> KinematicBackend:
    return KinematicBackend(dexter, URDF)


@pytest.mark.parametrize("channels", [{"sat_10"}, {"motion"}, {"hue_7", "motion"}, ()])
def test_what_is_not_looked_for_is_left_out_and_nothing_else(
    backend: KinematicBackend, channels: Collection[str]
) -> None:
    everything = _reported(backend, None)
    names = {name for regions in everything for found in regions.values() for name in found}
    assert names > {"sat_10", "motion"}
    wanted = [
        {
            camera: {name: region for name, region in found.items() if name in channels}
            for camera, found in regions.items()
        }
        for regions in everything
    ]
    assert _reported(backend, channels) == wanted
