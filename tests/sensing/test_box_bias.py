"""How far the centre of a box's silhouettes is off its own, as docs/documents states it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals

#: Edge, and by how much the position may be off, m; volumes, over the box's own.
BOUNDS = {0.06: 0.007, 0.10: 0.017, 0.15: 0.035, 0.20: 0.058}
VOLUMES = 1.0, 1.65
BOXES = 40
# Approximate place of the eyes, forwards and up, m.
_EYES = 0.25, 0.5


def box_on_the_table(edge: float, rng: np.random.Generator) -> StageDocument:
    """Return a stage with a red cube in view, at a random yaw."""
    x, y = rng.uniform(0.45, 0.8), rng.uniform(-0.3, 0.3)
    place = {"on": "table", "x": [x, x], "y": [y, y], "yaw": [0.0, math.pi]}
    cube = {"form": {"shape": "box", "size": [edge] * 3}, "mass": 0.2, "color": [1, 0, 0]}
    table = {"form": {"shape": "box", "size": [0.6, 1.2, 0.04]}, "position": [0.6, 0, -0.44]}
    pan = math.atan2(y, x - _EYES[0]) + rng.uniform(-0.1, 0.1)
    tilt = math.atan2(_EYES[1] + 0.42 - edge / 2, math.hypot(x - _EYES[0], y))
    joints = {"pan": pan, "tilt": tilt + rng.uniform(-0.1, 0.1)}
    context = {"things": ["cube"], "place": place, "joints": joints}
    return StageDocument.model_validate(
        {
            "cbdsl": 1, "kind": "stage", "name": "cubes", "robot": "dexter",
            "fixtures": {"table": table}, "things": {"cube": cube}, "contexts": {"all": context},
        }
    )  # fmt: skip


@pytest.mark.parametrize("edge", BOUNDS)
def test_bias_keeps_to_its_stated_bound(dexter: RobotDocument, urdf: Path, edge: float) -> None:
    backend, named = KinematicBackend(dexter, urdf), resources(dexter)
    wanted = named["stereo.red"], named["stereo.red.volume"]
    signals = Signals(dexter, Kinematics(dexter, urdf), wanted)
    rng, errors, volumes = np.random.default_rng(7), [], []
    for _ in range(BOXES):
        backend.reset(box_on_the_table(edge, rng), None, rng)
        signals.reset()
        for _ in range(8):
            signals.update(backend.observe())
            backend.step()
        position, volume = (signals.read(each) for each in wanted)
        if position is not None and volume is not None:
            truth = backend.truth.pose("cube").position
            errors.append(math.dist(position.value, truth))
            volumes.append(float(volume.value[0]) / edge**3)
    backend.close()
    assert len(errors) >= BOXES // 2, "most are wholly in view of both cameras"
    assert max(errors) < BOUNDS[edge]
    # The bias exists, so that the bound is necessary.
    assert np.median(errors) > BOUNDS[edge] / 5
    assert VOLUMES[0] < min(volumes) and max(volumes) < VOLUMES[1]
