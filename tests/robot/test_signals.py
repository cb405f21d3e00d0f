import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.kinematics import Kinematics
from cbdsl.robot.observation import Observation
from cbdsl.robot.resources import resources
from cbdsl.robot.signals import SensorError, Signals
from cbdsl.types.resource import Origin, Tip

STEP = 1e-6


def observe(dexter: RobotDocument, positions: np.ndarray, force: float = 0.0) -> Observation:
    """An observation with the same downward force on every fingertip and no image."""
    loads = {
        (hand, finger): np.array([0, 0, -force, 0, 0, 0], dtype=float)
        for hand, fingers in dexter.load_cells.items()
        for finger in fingers
    }
    return Observation(0.0, positions, np.zeros_like(positions), loads, {})


@pytest.fixture
def signals(dexter: RobotDocument, kinematics: Kinematics) -> Signals:
    return Signals(dexter, kinematics, resources(dexter).values())


def test_every_resource_can_be_read_and_fits_its_type(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray
) -> None:
    signals.update(observe(dexter, posture))
    signals.update(observe(dexter, posture, force=3.0))
    defined = 0
    for resource in resources(dexter).values():
        if resource.origin is Origin.MODEL:
            sample = signals.sampler(resource, np.random.default_rng(0)).draw()
            assert sample.shape == (resource.type.size,)
            continue
        reading = signals.read(resource)
        if reading is not None:
            defined += 1
            shape = {"orientation": (3, 3), "pose": (4, 4)}.get(
                resource.type.name, (resource.type.size,)
            )
            assert reading.value.shape == shape
            assert reading.jacobian.shape == (resource.type.size, len(signals.joints))
    # Everything but what needs an image.
    assert defined > 40


@pytest.mark.parametrize("name", ["right_arm", "left_hand", "right_arm.position", "head"])
def test_jacobians_of_moved_resources_by_finite_differences(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray, name: str
) -> None:
    resource = resources(dexter)[name]
    signals.update(observe(dexter, posture))
    here = signals.read(resource)
    assert here is not None
    for column in range(len(posture)):
        signals.update(observe(dexter, posture + STEP * np.eye(len(posture))[column]))
        there = signals.read(resource)
        assert there is not None
        slope = (there.value - here.value) / STEP
        assert here.jacobian[:, column] == pytest.approx(slope, abs=1e-4)


def test_a_standoff_moves_the_control_point_along_the_tips_normal(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray
) -> None:
    source = resources(dexter)["left_arm.position"].source
    assert isinstance(source, Tip)
    signals.update(observe(dexter, posture))
    near, far = signals.tip(source, 0.0), signals.tip(source, 0.1)
    normal = signals.kinematics.frame("left_palm").rotation[:, 2]
    assert far.value - near.value == pytest.approx(0.1 * normal)


def test_without_contact_force_signals_are_undefined(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray
) -> None:
    named = resources(dexter)
    signals.update(observe(dexter, posture))
    for name in ("right_hand.finger_1.force", "right_hand.finger_forces", "right_hand.net.force"):
        assert signals.read(named[name]) is None
    signals.update(observe(dexter, posture, force=2.0))
    net = signals.read(named["right_hand.net.force"])
    assert net is not None
    assert net.value == pytest.approx([0, 0, -6])


def test_what_load_cells_read_at_first_is_zero(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray
) -> None:
    signals.update(observe(dexter, posture, force=0.5))
    assert not signals.in_contact("right_hand")
    signals.update(observe(dexter, posture, force=2.5))
    force = signals.read(resources(dexter)["right_hand.finger_2.force"])
    assert force is not None
    assert force.value == pytest.approx([0, 0, -2.0])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_broken_sensor_is_named(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray, value: float
) -> None:
    with pytest.raises(SensorError, match=r"right_hand\.finger_1"):
        observation = observe(dexter, posture)
        observation.loads["right_hand", "finger_1"][1] = value
        signals.update(observation)
    with pytest.raises(SensorError, match="joint"):
        signals.update(observe(dexter, posture * value))


def test_a_pose_is_its_position_and_its_orientation(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray
) -> None:
    named = resources(dexter)
    signals.update(observe(dexter, posture))
    parts = (
        signals.read(named[f"left_arm.{part}"]) for part in ("pose", "position", "orientation")
    )
    pose, position, orientation = (part for part in parts if part is not None)
    assert pose.value[:3, 3] == pytest.approx(position.value)
    assert pose.value[:3, :3] == pytest.approx(orientation.value)
    assert pose.jacobian == pytest.approx(np.vstack([position.jacobian, orientation.jacobian]))
