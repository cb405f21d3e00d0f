"""Values, Jacobians and definedness of the resources of a robot."""

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.affordance_model import AffordanceModel
from cbdsl.robot.resources import resources
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.sensor_faults import SensorError
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading
from cbdsl.types.resource import AffordanceProbability, NetForces, Origin, Resource, Tip
from cbdsl.types.resource_type import PROBABILITY

STEP = 1e-6


def observe(dexter: RobotDocument, positions: np.ndarray, force: float = 0.0) -> Observation:
    """Return an observation with the same downward force on every fingertip and no image."""
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
        if resource.origin is Origin.SURFACE:
            continue
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
    # All resources except for image resources.
    assert defined > 40


@pytest.mark.parametrize(
    "name",
    [
        "right_arm",
        "left_hand",
        "right_arm.position",
        "head",
        "arms",
        "arms.position",
        "arms.centroid",
        "arms.separation",
    ],
)
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


@pytest.mark.parametrize("effector", ["left_arm", "right_arm", "arms"])
@pytest.mark.parametrize("part", ["position", "pose"])
def test_curvature_by_finite_differences(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray, effector: str, part: str
) -> None:
    """Compare the Jacobian of a tip's Jacobian."""
    row = signals.kinematic_rows.manipulator(effector, part, dexter.joints(effector))
    signals.update(observe(dexter, posture))
    here = signals.reading(row)
    assert here is not None and here.jacobian is not None
    for column in range(len(posture)):
        signals.update(observe(dexter, posture + STEP * np.eye(len(posture))[column]))
        there = signals.reading(row)
        assert there is not None
        slope = (there.value - here.value) / STEP
        assert here.jacobian[:, column] == pytest.approx(slope, abs=1e-4)


def test_load_changes_with_the_displacement_of_its_link(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray
) -> None:
    """Force -> displacement (Eq 3.37): the contact is a spring between link and world."""
    named = resources(dexter)
    signals.update(observe(dexter, posture))
    signals.update(observe(dexter, posture, force=2.0))
    finger = signals.read(named["left_hand.finger_1.wrench"])
    assert finger is not None
    moved = signals.kinematics.jacobian(dexter.load_cells["left_hand"]["finger_1"].link)
    stiffness = dexter.control.contact_stiffness
    assert finger.jacobian[:3] == pytest.approx(stiffness * moved[:3])
    assert finger.jacobian[3:] == pytest.approx(dexter.control.contact_torsion * moved[3:])
    net = signals.read(named["left_hand.net.force"])
    fingers = [signals.read(named[f"left_hand.finger_{i}.force"]) for i in (1, 2, 3)]
    assert net is not None
    assert net.jacobian == pytest.approx(sum(f.jacobian for f in fingers if f is not None))
    both = signals.read(named["hands.net_forces"])
    assert both is not None
    assert both.value[:3] == pytest.approx(net.value)


def test_carriers_map_hands_to_their_arms(signals: Signals) -> None:
    assert signals.touch.carriers == {"left_hand": "left_arm", "right_hand": "right_arm"}


def test_hand_presses_along_its_palms_normal(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray
) -> None:
    source = resources(dexter)["hands.net_forces"].source
    assert isinstance(source, NetForces)
    signals.update(observe(dexter, posture))
    untouched = signals.touch.palm_forces(source)
    assert untouched.value == pytest.approx([0, 0])
    assert not untouched.measured
    signals.update(observe(dexter, posture, force=1.0))
    down = [float(-signals.tips.normal(arm)[2]) for arm in ("left_arm", "right_arm")]
    assert signals.touch.palm_forces(source).value == pytest.approx(3.0 * np.array(down))
    found = signals.reading(signals.bind_normal_forces(source))
    assert found is not None
    assert found.value == pytest.approx(3.0 * np.array(down))


def test_standoff_moves_the_control_point_along_the_tips_normal(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray
) -> None:
    source = resources(dexter)["left_arm.position"].source
    assert isinstance(source, Tip)
    signals.update(observe(dexter, posture))
    ball = signals.bind_written(3)
    near = signals.bind(resources(dexter)["left_arm.position"])
    far = signals.kinematic_rows.tip_off(source, ball, (0.03, 0.05, 0.12))
    normal = signals.kinematics.frame("left_palm").rotation[:, 2]
    for radius, distance in ((0.0, 0.05), (0.07, 0.1), (0.2, 0.12)):
        signals.table.write(ball, Reading(np.zeros(3), None, 0, radius))
        found = [signals.reading(row) for row in (near, far)]
        assert found[0] is not None and found[1] is not None
        assert found[1].value - found[0].value == pytest.approx(distance * normal)


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


def test_first_reading_of_load_cells_is_their_zero(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray
) -> None:
    signals.update(observe(dexter, posture, force=0.5))
    assert not signals.touch.touching("right_hand")
    signals.update(observe(dexter, posture, force=2.5))
    force = signals.read(resources(dexter)["right_hand.finger_2.force"])
    assert force is not None
    assert force.value == pytest.approx([0, 0, -2.0])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_broken_sensor_is_named(
    dexter: RobotDocument, signals: Signals, posture: np.ndarray, value: float
) -> None:
    with pytest.raises(SensorError, match=r"right_hand\.finger_1"):
        observation = observe(dexter, posture)
        observation.loads["right_hand", "finger_1"][1] = value
        signals.update(observation)
    with pytest.raises(SensorError, match=r"joint \w+ of \w+ is not finite"):
        signals.update(observe(dexter, posture * value))


def test_pose_is_its_position_and_its_orientation(
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


def test_probability_is_that_of_the_features_now(
    dexter: RobotDocument, kinematics: Kinematics, posture: np.ndarray
) -> None:
    """Leave it undefined without one of its features; use counts for an action without features."""
    own = resources(dexter)
    palms = tuple(own[f"{side}_arm.position"] for side in ("left", "right"))
    seen, model = np.zeros(6), AffordanceModel.fresh(np.ones(6))
    for number in range(8):
        model = model.updated(seen + 0.1 * number, rewarded=number % 2 == 0)
    bare = AffordanceModel.fresh(np.zeros(0)).updated(None, rewarded=True)

    def affords(model: AffordanceModel, *features: Resource) -> Resource:
        source = AffordanceProbability("some", "act", model, features)
        return Resource("affords.act", PROBABILITY, Origin.ENVIRONMENT, source)

    blind = next(each for each in own.values() if "stereo" in each.name)
    asked = affords(model, *palms), affords(bare), affords(model, palms[0], blind)
    signals = Signals(dexter, kinematics, asked)
    signals.update(observe(dexter, posture))
    values = []
    for palm in palms:
        reading = signals.read(palm)
        assert reading is not None
        values.append(reading.value)
    with_features, without, undefined = (signals.read(each) for each in asked)
    assert with_features is not None and without is not None and undefined is None
    assert with_features.value == pytest.approx(model.reward_given(np.concatenate(values)))
    assert without.value == pytest.approx(bare.reward_given(np.zeros(0)))


def test_links_have_rows_of_their_own_and_of_their_middle(
    dexter: RobotDocument, kinematics: Kinematics, posture: np.ndarray
) -> None:
    cells = [each.link for each in dexter.load_cells["right_hand"].values()]
    signals = Signals(dexter, kinematics, ())
    bind = signals.kinematic_rows.links
    rows, middle = [bind([link]) for link in cells], bind(cells)
    assert bind(cells) == middle and bind(cells[:1]) == rows[0]
    signals.update(observe(dexter, posture))
    signals.refresh(signals.select([*rows, middle]))
    places = [kinematics.frame(link).position for link in cells]
    for row, place in zip(rows, places, strict=True):
        assert signals.table.values(row).shape == (3,)
        np.testing.assert_allclose(signals.table.values(row), place, atol=1e-12)
    np.testing.assert_allclose(signals.table.values(middle), np.mean(places, axis=0), atol=1e-12)
    jacobians = [signals.table.rows(row) for row in rows]
    assert np.abs(jacobians[0]).max() > 0.1
    np.testing.assert_allclose(signals.table.rows(middle), np.mean(jacobians, axis=0), atol=1e-12)
    pair = bind(cells[1:])
    signals.refresh(signals.select([pair]))
    np.testing.assert_allclose(signals.table.values(pair), np.mean(places[1:], axis=0), atol=1e-12)


def test_rows_are_refreshed_for_each_observation(
    dexter: RobotDocument, kinematics: Kinematics, posture: np.ndarray
) -> None:
    """Rows refreshed for one tick are refreshed again in the next."""
    signals = Signals(dexter, kinematics, ())
    tip = signals.bind(resources(dexter)["right_arm.position"])
    selection = signals.select([tip])
    for share in (1.0, 0.5, 0.0):
        signals.update(observe(dexter, share * posture))
        signals.refresh(selection)
        place = signals.tips.point("right_arm").position
        np.testing.assert_allclose(signals.table.values(tip), place, atol=1e-12)
