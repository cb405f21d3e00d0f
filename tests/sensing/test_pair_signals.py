"""Constellation and offset of two objects, from pixels, against the simulator's truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import embody
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.pair_names import pair_resource
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading

StageNamed = Callable[[str], StageDocument]
NAMES = {"seen": "left.red.to.blue", "back": "left.blue.to.red", "apart": "stereo.red.to.blue"}


class PairWatcher:
    """Looks at two things with a robot that keeps still."""

    def __init__(self, kind: str, dexter: RobotDocument, urdf: Path, kinematics: Kinematics):
        engine = {"rendered": "bullet", "ideal": "kinematic"}[kind]
        self.backend = embody(engine, dexter, urdf, cameras=kind)
        known = resources(dexter)
        self.named = {key: pair_resource(name, known) for key, name in NAMES.items()}
        self.signals = Signals(dexter, kinematics, [r for r in self.named.values() if r])

    def look(self, stage: StageDocument, seed: int) -> dict[str, Reading | None]:
        self.backend.reset(stage, None, np.random.default_rng(seed))
        self.signals.reset()
        for _ in range(25):
            self.signals.update(self.backend.observe())
            self.backend.apply(self.signals.positions.copy())
            self.backend.step()
        return {key: self.signals.read(each) for key, each in self.named.items() if each}


@pytest.fixture(params=["rendered", "ideal"])
def pair_watcher(
    request: pytest.FixtureRequest, dexter: RobotDocument, urdf: Path, kinematics: Kinematics
) -> Iterator[PairWatcher]:
    made = PairWatcher(request.param, dexter, urdf, kinematics)
    yield made
    made.backend.close()


def test_object_on_another_one_has_an_upward_offset_and_a_smaller_scale(
    pair_watcher: PairWatcher, stage: StageNamed
) -> None:
    """Stack a cube of 8 cm or a ball of 10 cm on a box of 14 cm."""
    for seed in range(3):
        read = pair_watcher.look(stage("stacked"), seed)
        seen, back, apart = read["seen"], read["back"], read["apart"]
        assert seen is not None and back is not None and apart is not None
        truth = pair_watcher.backend.truth  # type: ignore[attr-defined]
        known = truth.pose("upper").position - truth.pose("lower").position
        assert apart.value[:2] == pytest.approx(known[:2], abs=0.05)
        assert apart.value[2] > 0.04
        assert 0.4 < seen.value[0] < 1.0
        # Seen from the other one, ratios are the inverse, and the turn is reversed.
        assert seen.value[:2] * back.value[:2] == pytest.approx(1.0)
        assert seen.value[2] == pytest.approx(-back.value[2])


def test_absent_objects_have_no_pair_signals(pair_watcher: PairWatcher, stage: StageNamed) -> None:
    read = pair_watcher.look(stage("table_right"), 0)
    assert list(read.values()) == [None, None, None]
