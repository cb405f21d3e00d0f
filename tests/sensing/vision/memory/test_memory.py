"""Memory of positions and sizes of objects that are occluded or out of view."""

import numpy as np
import pytest

from cbdsl.documents.robot import Regions
from cbdsl.sensing.vision.memory.memory import PositionMemory

WHERE = np.array([0.5, -0.2, -0.35])
WHOLE = (0.02, 0.02)
HALF = (0.01, 0.01)
FRAME = 1 / 15
Pair = tuple[float, float]
# Both lines of sight lead to the remembered place of the object.
AT_IT = (0.0, 0.0)


@pytest.fixture
def memory() -> PositionMemory:
    return PositionMemory(Regions())


def test_sighting_defines_position_and_radius(memory: PositionMemory) -> None:
    assert memory.position is None
    assert memory.see(0.0, WHERE, [np.pi * 0.07**2] * 2)
    assert memory.position == pytest.approx(WHERE)
    assert memory.radius == pytest.approx(0.07)


def test_half_hidden_region_moves_nothing(memory: PositionMemory) -> None:
    memory.see(0.0, WHERE, WHOLE)
    assert not memory.see(FRAME, WHERE + 0.05, (0.02, 0.015))
    assert memory.position == pytest.approx(WHERE)


def test_object_first_seen_in_part_is_replaced_once_seen_whole(
    memory: PositionMemory,
) -> None:
    """Show one camera a sliver beside the hand, whose middle is not the middle of the object."""
    assert memory.see(0.0, WHERE, (0.0001, 0.0245))
    whole = np.add(WHERE, (0.05, 0.0, 0.1))
    assert memory.see(FRAME, whole, (0.0142, 0.0132))
    assert memory.position == pytest.approx(whole)
    assert memory.radius == pytest.approx(np.sqrt(0.0137 / np.pi))
    assert memory.since == 0.0
    assert memory.velocity is None
    assert not memory.see(2 * FRAME, WHERE, (0.0001, 0.0245))
    assert memory.position == pytest.approx(whole)


def test_has_shrunk_if_one_camera_sees_less_than_before(
    memory: PositionMemory,
) -> None:
    assert not memory.has_shrunk(WHOLE, AT_IT)
    memory.see(0.0, WHERE, WHOLE)
    assert not memory.has_shrunk(WHOLE, AT_IT)
    assert not memory.has_shrunk((0.03, 0.02), AT_IT)
    assert memory.has_shrunk((0.02, 0.0199), AT_IT)
    memory.forget_size(HALF, AT_IT)
    assert not memory.has_shrunk(HALF, AT_IT)


@pytest.mark.parametrize(
    ("sizes", "aside", "has_shrunk"),
    [
        ((0.01, 0.01), AT_IT, True),
        ((0.01, 0.0111), AT_IT, True),
        ((0.01, 0.0112), AT_IT, False),  # over a tenth more in one camera
        ((0.02, 0.01), AT_IT, False),
        ((0.02, 0.01), (0.0, 0.3), False),  # the apparent motion of a half hidden object
        ((0.02, 0.014), AT_IT, False),
        ((0.02, 0.014), (0.3, 0.0), True),  # elsewhere, and turned
        ((0.02, 0.014), (0.3, 0.3), True),
        ((0.02, 0.01), (0.3, 0.3), False),  # no more than a part of it
        ((0.0006, 0.0044), (0.3, 0.3), False),
    ],
)
def test_object_lost_by_one_camera_is_hidden_unless_it_moved(
    memory: PositionMemory, sizes: Pair, aside: Pair, has_shrunk: bool
) -> None:
    memory.see(0.0, WHERE, WHOLE)
    assert memory.has_shrunk(sizes, aside) is has_shrunk


def test_gradual_occlusion_is_recognised(memory: PositionMemory) -> None:
    """Show one camera a little less of it in each image."""
    memory.see(0.0, WHERE, WHOLE)
    for number in range(1, 20):
        sizes = (0.02, 0.02 * 0.95**number)
        if memory.has_shrunk(sizes, AT_IT):
            memory.forget_size(sizes, AT_IT)
        memory.see(number * FRAME, WHERE + 0.005 * number, sizes)
    assert memory.position == pytest.approx(WHERE, abs=0.02)


@pytest.mark.parametrize("moves", [True, False])
def test_gradual_occlusion_gives_no_velocity(memory: PositionMemory, moves: bool) -> None:
    """Move its middle in one image alone as it loses a part there; a motion takes no part away."""
    for number in range(5):
        share = 1.0 if moves else 0.97**number
        sizes, place = (0.02, 0.02 * share), WHERE + np.array([0.01 * number, 0.0, 0.0])
        if memory.has_shrunk(sizes, AT_IT):
            memory.forget_size(sizes, AT_IT)
        memory.see(number * FRAME, place, sizes)
    velocity = memory.velocity
    assert velocity is not None
    assert (velocity[0] > 0.1) if moves else not velocity.any()


def test_turned_and_moved_object_is_seen_again(memory: PositionMemory) -> None:
    memory.see(0.0, WHERE, WHOLE)
    there, sizes, aside = WHERE + 0.3, (0.02, 0.014), (0.3, 0.3)
    assert memory.has_shrunk(sizes, aside)
    memory.forget_size(sizes, aside)
    assert memory.see(FRAME, there, sizes)
    assert not memory.has_shrunk(sizes, AT_IT)


def test_explained_loss_is_remembered_and_an_unexplained_one_forgotten(
    memory: PositionMemory,
) -> None:
    """Count the time of a loss from its last explanation."""
    memory.see(0.0, WHERE, WHOLE)
    memory.miss(10.0, explained=True)
    assert memory.position is not None
    memory.miss(10.4, explained=False)
    assert memory.position is not None
    memory.miss(10.6, explained=False)
    assert memory.position is None


def test_size_outlives_a_loss_until_it_is_forgotten(memory: PositionMemory) -> None:
    memory.see(0.0, WHERE, WHOLE)
    memory.miss(9.0, explained=False)
    assert not memory.see(9.1, WHERE, HALF)
    memory.forget_size(HALF, AT_IT)
    assert memory.see(9.2, WHERE, HALF)


def test_steady_motion_is_predicted_while_hidden_and_stops_at_contact(
    memory: PositionMemory,
) -> None:
    velocity = np.array([0.0, 0.05, 0.0])
    for frame in range(60):
        time = frame * FRAME
        memory.predict(FRAME, time)
        memory.see(time, WHERE + velocity * time, WHOLE)
    for frame in range(60, 90):
        memory.predict(FRAME, frame * FRAME)
        memory.miss(frame * FRAME, explained=True)
    truth = WHERE + velocity * 89 * FRAME
    assert memory.position == pytest.approx(truth, abs=0.005)
    memory.rest()
    held = memory.position
    memory.predict(FRAME, 90 * FRAME)
    assert memory.position is held


def test_still_thing_does_not_creep_from_noise(memory: PositionMemory) -> None:
    rng = np.random.default_rng(7)
    for frame in range(300):
        memory.predict(FRAME, frame * FRAME)
        memory.see(frame * FRAME, WHERE + rng.normal(0, 5e-4, 3), WHOLE)
    assert memory.position == pytest.approx(WHERE, abs=2e-3)


def steady(
    memory: PositionMemory, velocity: np.ndarray, sightings: int, first: float = 0.0
) -> float:
    """Show sightings of a steady motion without errors; return the time of the last one, s."""
    for number in range(sightings):
        time = first + number * FRAME
        memory.predict(FRAME, time)
        memory.see(time, WHERE + velocity * (time - first), WHOLE)
    return time


def test_velocity_of_few_sightings_is_their_line(memory: PositionMemory) -> None:
    """Fit the line through two of them exactly, and report no velocity before the third."""
    velocity = np.array([0.04, -0.03, 0.02])
    steady(memory, velocity, 2)
    assert memory.velocity is None
    assert memory.position == pytest.approx(WHERE + velocity * FRAME)
    memory.reset()
    assert memory.velocity is None and memory.since == 0.0
    steady(memory, velocity, 3, first=5.0)
    assert memory.velocity == pytest.approx([0.04, -0.03, 0.0]), "things move on the level"
    assert memory.since == 5.0
    told = memory.velocity
    assert told is not None
    told[:] = 9.0
    assert memory.velocity == pytest.approx([0.04, -0.03, 0.0])


def test_after_many_sightings_the_filter_s_own_gains_correct(memory: PositionMemory) -> None:
    last = steady(memory, np.zeros(3), 40)
    off = np.array([0.01, 0.0, 0.02])
    memory.see(last + FRAME, WHERE + off, WHOLE)
    alpha, beta = Regions().gains
    assert memory.position == pytest.approx(WHERE + alpha * off)
    assert memory.velocity == pytest.approx([beta * 0.01 / FRAME, 0.0, 0.0])


def test_simultaneous_sightings_count_as_1_ms_apart(memory: PositionMemory) -> None:
    for _ in range(2):
        memory.see(1.0, WHERE, WHOLE)
    memory.see(1.0, WHERE + np.array([1e-6, 0.0, 0.0]), WHOLE)
    assert memory.velocity == pytest.approx([0.5e-3, 0.0, 0.0])


@pytest.mark.parametrize(("speed", "moves"), [(0.0079, False), (0.0081, True)])
def test_fast_object_is_extrapolated_for_a_while(
    memory: PositionMemory, speed: float, moves: bool
) -> None:
    velocity = np.array([speed * 0.6, -speed * 0.8, 0.0])
    last = steady(memory, velocity, 2)
    assert memory.position is not None
    before = memory.position.copy()
    memory.predict(FRAME, last + 2.99)
    assert memory.position == pytest.approx(before + velocity * FRAME * moves)
    assert not memory.is_lost(last + 2.99)
    assert memory.is_lost(last + 3.01) is moves
    moved = memory.position.copy()
    memory.predict(FRAME, last + 3.01)
    assert memory.position == pytest.approx(moved)
    memory.rest()
    assert not memory.is_lost(last + 9.0)


def test_forgotten_object_is_not_extrapolated(memory: PositionMemory) -> None:
    last = steady(memory, np.array([0.1, 0.0, 0.0]), 3)
    memory.miss(last + 0.49, explained=False)
    assert memory.position is not None and memory.velocity is not None
    memory.miss(last + 0.51, explained=False)
    memory.predict(FRAME, last + 0.6)
    memory.carry(np.ones(3))
    assert memory.position is None and memory.velocity is None
    memory.see(last + 1.0, WHERE, WHOLE)
    assert memory.since == last + 1.0
    memory.predict(FRAME, last + 1.0 + FRAME)
    assert memory.position == pytest.approx(WHERE), "it begins at rest"


def test_displacements_count_from_the_tick_of_the_image_on(memory: PositionMemory) -> None:
    memory.see(0.0, WHERE, WHOLE)
    for number in range(1, 5):
        memory.predict(0.1, 0.1 * number)
        memory.carry(np.array([10.0**-number, 0.0, 0.0]))
    assert memory.position == pytest.approx(WHERE + np.array([0.1111, 0.0, 0.0]))
    assert memory.moved_since(0.2) == pytest.approx([0.0111, 0.0, 0.0])
    assert memory.moved_since(0.3) == pytest.approx([0.0011, 0.0, 0.0])
    assert memory.moved_since(0.41) == pytest.approx(np.zeros(3))
    assert memory.moved_since(0.0) == pytest.approx(np.zeros(3)), "older ones are gone by then"


def test_prediction_begins_with_its_tick(memory: PositionMemory) -> None:
    last = steady(memory, np.array([0.15, 0.0, 0.0]), 3)
    memory.predict(FRAME, last + FRAME)
    step = memory.moved_since(last - FRAME / 2)
    assert step == pytest.approx([0.15 * FRAME, 0.0, 0.0])
    assert memory.moved_since(last + FRAME / 2) == pytest.approx(np.zeros(3))


def test_displacements_are_kept_for_longer_than_any_image_is_late(memory: PositionMemory) -> None:
    memory.see(0.0, WHERE, WHOLE)
    for number in range(1, 25):
        memory.predict(0.1, 0.1 * number)
        memory.carry(np.array([1.0, 0.0, 0.0]))
    assert memory.moved_since(0.0) == pytest.approx([16.0, 0.0, 0.0])


def test_sizes_are_the_largest_of_each_camera(memory: PositionMemory) -> None:
    memory.see(0.0, WHERE, (0.020, 0.010))
    assert memory.see(FRAME, WHERE, (0.0197, 0.012))
    assert memory.radius == pytest.approx(np.sqrt((0.020 + 0.012) / 2 / np.pi))
    assert not memory.see(FRAME, WHERE, (0.0195, 0.012)), "less than 0.98 of the largest"
    assert memory.see(FRAME, WHERE, (0.030, 0.0118))
    assert memory.radius == pytest.approx(np.sqrt((0.030 + 0.012) / 2 / np.pi))
    memory.reset()
    assert memory.radius == 0.0
    assert memory.see(0.0, WHERE, HALF)


def test_rejected_sighting_changes_nothing(memory: PositionMemory) -> None:
    last = steady(memory, np.zeros(3), 3)
    assert not memory.see(last + 0.4, WHERE + 0.2, HALF)
    memory.miss(last + 0.51, explained=False)
    assert memory.position is None, "it was accounted for when it was last believed"


def test_memory_keeps_when_and_where_an_object_was_last_seen(memory: PositionMemory) -> None:
    memory.see(1.0, WHERE, WHOLE)
    assert memory.last is None
    memory.miss(9.0, explained=False)
    assert memory.position is None and memory.last is not None
    assert memory.last[0] == 1.0
    np.testing.assert_allclose(memory.last[1], WHERE)
    memory.reset()
    assert memory.last is None
