import numpy as np
import pytest

from cbdsl.documents.robot import Regions
from cbdsl.sensing.memory import PositionMemory

WHERE = np.array([0.5, -0.2, -0.35])
WHOLE = (0.02, 0.02)
HALF = (0.01, 0.01)
FRAME = 1 / 15


@pytest.fixture
def memory() -> PositionMemory:
    return PositionMemory(Regions())


def test_a_sighting_defines_position_and_radius(memory: PositionMemory) -> None:
    assert memory.position is None
    assert memory.see(0.0, WHERE, [np.pi * 0.07**2] * 2)
    assert memory.position == pytest.approx(WHERE)
    assert memory.radius == pytest.approx(0.07)


def test_a_half_hidden_region_moves_nothing(memory: PositionMemory) -> None:
    memory.see(0.0, WHERE, WHOLE)
    assert not memory.see(FRAME, WHERE + 0.05, (0.02, 0.015))
    assert memory.position == pytest.approx(WHERE)


def test_it_looks_smaller_where_one_camera_sees_less_of_it_than_before(
    memory: PositionMemory,
) -> None:
    assert not memory.looks_smaller(WHOLE)
    memory.see(0.0, WHERE, WHOLE)
    assert not memory.looks_smaller(WHOLE)
    assert not memory.looks_smaller((0.03, 0.02))
    assert memory.looks_smaller((0.03, 0.0199))
    memory.forget_size()
    assert not memory.looks_smaller(HALF)


def test_an_explained_loss_is_held_and_any_other_forgotten_soon(memory: PositionMemory) -> None:
    """Counted from when it was last accounted for."""
    memory.see(0.0, WHERE, WHOLE)
    memory.miss(10.0, explained=True)
    assert memory.position is not None
    memory.miss(10.4, explained=False)
    assert memory.position is not None
    memory.miss(10.6, explained=False)
    assert memory.position is None


def test_the_size_outlives_a_loss_until_it_is_forgotten(memory: PositionMemory) -> None:
    memory.see(0.0, WHERE, WHOLE)
    memory.miss(9.0, explained=False)
    assert not memory.see(9.1, WHERE, HALF)
    memory.forget_size()
    assert memory.see(9.2, WHERE, HALF)


def test_a_steady_motion_is_predicted_while_hidden_and_stops_at_contact(
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


def test_a_still_thing_does_not_creep_from_noise(memory: PositionMemory) -> None:
    rng = np.random.default_rng(7)
    for frame in range(300):
        memory.predict(FRAME, frame * FRAME)
        memory.see(frame * FRAME, WHERE + rng.normal(0, 5e-4, 3), WHOLE)
    assert memory.position == pytest.approx(WHERE, abs=2e-3)
