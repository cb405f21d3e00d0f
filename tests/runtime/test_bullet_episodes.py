"""Whole episodes with physics, on seeds without any tuning, judged by the simulator.

Reported touches are compared with contacts and forces that no controller can read.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.transition import Transition
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from tests.conftest import Checked

pytestmark = pytest.mark.slow

LEFT = {"arm": "left_arm", "hand": "left_hand"}

# Contact forces ripple from physics step to physics step, and load cells smooth that. Both are
# compared over half a second, N. The difference is noise and the cells' delay.
HOLD_TICKS = 30
LOAD_TOLERANCE = 0.15


@dataclass
class Judged:
    """Episode, its received events, and the backend as the episode left it."""

    result: EpisodeResult
    transitions: list[Transition]
    last: Tick
    backend: BulletBackend


Perform = Callable[..., Judged]


@pytest.fixture(scope="module")
def perform(
    dexter: RobotDocument,
    kinematics: Kinematics,
    checked: Checked,
    stage: Callable[[str], StageDocument],
    bullet: BulletBackend,
) -> Perform:
    def run(
        program: str,
        on: str,
        seed: int,
        context: str | None = None,
        backend: BulletBackend | None = None,
        **values: str,
    ) -> Judged:
        body = backend or bullet
        runner = Runner(dexter, kinematics, checked(program, **values), body)
        transitions: list[Transition] = []
        last: list[Tick] = []

        def note(tick: Tick) -> None:
            last[:] = [tick]

        result = runner.run(stage(on), seed, context, EpisodeListeners(transitions.append, note))
        return Judged(result, transitions, last[0], body)

    return run


def thing_of(judged: Judged) -> str:
    """Return the one object that is shown."""
    (thing,) = set(judged.backend.truth.names()) - {"table", "pedestal"}
    return thing


def require_touch(judged: Judged, hand: str) -> None:
    """Assert that all fingertips of a hand press on the object, as hard as their load cells say."""
    result, backend = judged.result, judged.backend
    assert result.rewarded, result.ending
    pressing = np.linalg.norm(true_forces(judged, hand), axis=1)
    assert (pressing > 0.1).all(), f"{pressing} N: {result.ending}"
    true, felt, signals = [], [], judged.last.signals
    for _ in range(HOLD_TICKS):
        backend.step()
        true.append(true_forces(judged, hand))
        signals.update(backend.observe())
        first, last = signals.touch.span(hand)
        felt.append(signals.touch.loads[first:last, :3].copy())
    assert np.mean(felt, axis=0) == pytest.approx(np.mean(true, axis=0), abs=LOAD_TOLERANCE)


def true_forces(judged: Judged, hand: str) -> np.ndarray:
    """Return the force of each fingertip on the object, N, world frame, shape (fingers, 3)."""
    cells = [cell for cell in judged.last.observation.loads if cell[0] == hand]
    forces = np.zeros((len(cells), 3))
    for touch in judged.backend.truth.touches(thing_of(judged)):
        if touch.cell in cells:
            forces[cells.index(touch.cell)] += touch.force
    return forces


def require_on_table(judged: Judged) -> None:
    x, y, z = judged.backend.truth.pose(thing_of(judged)).position
    assert 0.3 < x < 0.9 and abs(y) < 0.6 and -0.42 < z < -0.2


@pytest.mark.parametrize("seed", [70001, 70002, 70003])
@pytest.mark.parametrize(
    ("on", "values"), [("table_right", {}), ("table_left", LEFT)], ids=["right", "left"]
)
def test_object_on_the_table_is_touched(
    perform: Perform, on: str, values: dict[str, str], seed: int
) -> None:
    judged = perform("reachtouch", on, seed, **values)
    require_touch(judged, values.get("hand", "right_hand"))
    require_on_table(judged)
    assert judged.result.predicates[-1] == "X11"


@pytest.mark.parametrize("seed", [70001, 70002])
@pytest.mark.parametrize("on", ["moving_right", "noisy_right"])
def test_moving_or_poorly_seen_object_is_touched(perform: Perform, on: str, seed: int) -> None:
    judged = perform("reachtouch", on, seed)
    require_touch(judged, "right_hand")
    require_on_table(judged)


@pytest.mark.parametrize("context", ["ball", "box"])
def test_held_out_object_is_touched_by_probing(perform: Perform, context: str) -> None:
    judged = perform("tactileprobe", "held_right", 70001, context)
    require_touch(judged, "right_hand")
    assert judged.result.predicates[-1][1] == "1"


@pytest.mark.parametrize(("on", "final"), [("absent", "-XX"), ("out_of_reach", "X1-")])
def test_untouchable_object_earns_no_reward(perform: Perform, on: str, final: str) -> None:
    judged = perform("reachtouch", on, 70001)
    assert not judged.result.rewarded
    assert judged.result.predicates[-1] == final
    assert sum(each.reward for each in judged.transitions if each.depth == 0) == 0


def test_thrown_object_earns_no_reward(perform: Perform) -> None:
    judged = perform("reachtouch", "thrown", 70001)
    assert not judged.result.rewarded
    assert "1" not in {each.next_state[2] for each in judged.transitions if each.depth == 0}


@pytest.fixture
def tiny(dexter: RobotDocument, urdf: Path) -> Iterator[BulletBackend]:
    vision = dexter.vision.model_copy(update={"renderer": "tiny"})
    backend = BulletBackend(dexter.model_copy(update={"vision": vision}), urdf)
    yield backend
    backend.close()


def test_episode_with_the_slower_renderer_is_rewarded(
    perform: Perform, tiny: BulletBackend
) -> None:
    judged = perform("reachtouch", "table_right", 70004, "in_view", tiny)
    assert "tiny" in judged.result.renderer.lower()
    require_touch(judged, "right_hand")


@pytest.mark.parametrize("seed", [811, 812])
def test_box_in_both_hands_is_moved_to_the_best_localizability(perform: Perform, seed: int) -> None:
    """LOCALIZABILITY subject to TOUCH (Eq 3.44): phi_l falls, the box stays between the hands."""
    judged = perform("bimanualinspect", "box_between_hands", seed)
    assert judged.result.predicates[-1] == "X1-"
    grabbed = [t for t in judged.transitions if t.program == "bimanualgrab" and t.reward]
    assert grabbed
    signals = judged.last.signals
    box = judged.backend.truth.pose(thing_of(judged)).position
    tips = [signals.tips.point(f"{side}_arm").position for side in ("left", "right")]
    centroid = np.mean(tips, axis=0)
    assert np.linalg.norm(box - centroid) < 0.1
    head = signals.kinematics.frame("left_camera").position
    assert np.linalg.norm(box - head) < 0.62  # it was shown at 0.8 m


def palm_of(judged: Judged, hand: str) -> np.ndarray:
    """Return the vector from a palm to the object, by the simulator, m."""
    palm = judged.backend.truth.link_pose(f"{hand}_palm").position
    return judged.backend.truth.pose(thing_of(judged)).position - palm


@pytest.mark.parametrize("seed", [70001, 70002, 70003])
def test_hidden_spot_on_a_held_object_is_found(perform: Perform, seed: int) -> None:
    judged = perform("visualinspect", "spotted_right", seed, "hidden")
    predicates = judged.result.predicates
    assert judged.result.rewarded, judged.result.ending
    assert predicates[:4] == ("XXX", "XX-", "0XX", "1XX")
    assert predicates[-1] == "X01"
    assert np.linalg.norm(palm_of(judged, "right")) < 0.15
    assert judged.backend.truth.pose(thing_of(judged)).position[2] > -0.3


def test_visible_spot_is_tracked_immediately(perform: Perform) -> None:
    judged = perform("visualinspect", "spotted_right", 70001, "facing")
    assert judged.result.predicates == ("XXX", "XX0", "XX1")
    assert judged.result.rewarded
    require_on_table(judged)


@pytest.mark.parametrize("seed", [70001, 70002, 70003])
def test_object_held_by_one_hand_is_touched_by_the_other(perform: Perform, seed: int) -> None:
    """Hold the object in the air between both palms, with fingers of both hands on it."""
    judged = perform("bimanualtouch", "table_right", seed)
    predicates = judged.result.predicates
    assert judged.result.rewarded, judged.result.ending
    assert predicates[:4] == ("XXX", "0XX", "1XX", "X0-")
    # The arms' rest is judged from scratch after the contact.
    assert "X00" in predicates
    assert predicates[-1] in ("X01", "X11")
    for side in ("left", "right"):
        assert np.linalg.norm(palm_of(judged, side)) < 0.16
        pressing = np.linalg.norm(true_forces(judged, f"{side}_hand"), axis=1)
        assert (pressing > 0.1).any(), f"{side}: {pressing} N"
    assert judged.backend.truth.pose(thing_of(judged)).position[2] > -0.2
