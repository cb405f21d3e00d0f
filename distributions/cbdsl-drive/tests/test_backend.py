"""Backend of a real robot without a transport: states, and motions that it must never command."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from peer import Answers, Peer, backend

from cbdsl.backends.backend import AttendedBackend, BackendError
from cbdsl.documents.stage import StageDocument
from cbdsl.extend.driver import (
    DescriptionSample,
    Endpoint,
    FaultSample,
    JointSample,
    Sample,
    Setup,
    StopSample,
)
from cbdsl_drive.backend import DrivenBackend
from cbdsl_drive.person import Consent, RefusingPerson
from cbdsl_drive.safety_supervisor import State
from tests.driven_robot import LOWER, PERIOD, UPPER, URDF, VELOCITY

RNG = np.random.default_rng(0)


def begin(driven: DrivenBackend, stage: StageDocument) -> None:
    driven.reset(stage, None, RNG)


def run(driven: DrivenBackend, references: Callable[[int], np.ndarray], ticks: int) -> None:
    for tick in range(ticks):
        driven.apply(references(tick))
        driven.step()


def sine(tick: int) -> np.ndarray:
    return 0.3 * np.sin(np.array([0.05, 0.04]) * tick)


def test_backend_is_attended(urdf: Path) -> None:
    assert isinstance(backend(Peer(), urdf), AttendedBackend)


def test_backend_follows_references_and_reports_states(urdf: Path, stage: StageDocument) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    assert driven.supervisor.state is State.OFF
    begin(driven, stage)
    assert driven.supervisor.state is State.READY
    assert not peer.commands, "nothing moves before the first reference"
    assert driven.deadline is None
    run(driven, sine, 50)
    assert driven.supervisor.state is State.RUNNING
    assert driven.deadline == pytest.approx(0.05)
    assert driven.observe().time == pytest.approx(50 * PERIOD, abs=2 * PERIOD)
    assert driven.observe().positions == pytest.approx(sine(49), abs=0.02)
    driven.close()
    assert peer.closed
    assert driven.supervisor.state is State.HELD


FAULTS: dict[str, tuple[Callable[[Peer], None], str]] = {
    "silence": (lambda peer: setattr(peer, "silent", True), "no new state of any joint"),
    "missing joint": (
        lambda peer: setattr(peer, "alter", lambda s: [_only(s, [0])]),
        "no new state of joint 'second'",
    ),
    "doubled joint": (
        lambda peer: setattr(peer, "alter", lambda s: [_only(s, [0, 1, 0])]),
        "names joint 'first' twice",
    ),
    "nan": (
        lambda peer: setattr(peer, "alter", lambda s: [s._replace(positions=(math.nan, 0.0))]),
        "sends nan in positions of joint 'first'",
    ),
    "clock ahead": (lambda peer: setattr(peer, "skew", 5.0), "5.000 s ahead of"),
    "clock behind": (lambda peer: setattr(peer, "skew", -5.0), "5.000 s behind"),
    "stamps stand still": (
        lambda peer: setattr(peer, "alter", _standing(peer)),
        "no new state of any joint",
    ),
    "frozen states": (lambda peer: setattr(peer, "alter", _frozen()), "are frozen"),
    "effort": (
        lambda peer: setattr(peer, "alter", lambda s: [s._replace(efforts=(0.0, 6.0))]),
        "has the effort 6.00, and its limit is 5.00",
    ),
    "position": (
        lambda peer: setattr(peer, "alter", lambda s: [s._replace(positions=(3.0, 0.0))]),
        "joint 'first' is at 3.000, outside of its limits",
    ),
    "speed": (
        lambda peer: setattr(peer, "alter", lambda s: [s._replace(velocities=(9.0, 0.0))]),
        "joint 'first' moves at 9.000/s",
    ),
    "stuck": (lambda peer: setattr(peer, "moving", False), "from its reference"),
    "emergency stop": (
        lambda peer: setattr(peer, "alter", lambda s: [s, StopSample("arm", True)]),
        "the emergency stop of driver 'arm' is pressed",
    ),
    "another commander": (
        lambda peer: peer.faults.append(FaultSample("arm", "another commander writes")),
        "another commander writes",
    ),
    "short message": (
        lambda peer: setattr(peer, "alter", lambda s: [s._replace(positions=(0.0,))]),
        "sends 1 positions for 2 joints",
    ),
    "two publishers": (
        lambda peer: setattr(peer, "alter", lambda s: [s, s._replace(source=2)]),
        "two publishers send states of joint 'first'",
    ),
    "other robot": (
        lambda peer: setattr(peer, "alter", lambda s: [s, DescriptionSample("arm", "<robot/>")]),
        "the robot's description",
    ),
}


def _only(sample: JointSample, which: list[int]) -> JointSample:
    parts = (sample.names, sample.positions, sample.velocities)
    names, positions, velocities = (tuple(part[i] for i in which) for part in parts)
    return sample._replace(names=names, positions=positions, velocities=velocities)


def _standing(peer: Peer) -> Callable[[JointSample], list[JointSample]]:
    first: list[float] = []

    def alter(sample: JointSample) -> list[JointSample]:
        first.append(sample.stamp)
        return [sample._replace(stamp=first[0])]

    return alter


def _frozen() -> Callable[[JointSample], list[JointSample]]:
    first: list[JointSample] = []

    def alter(sample: JointSample) -> list[JointSample]:
        first.append(sample)
        return [first[0]._replace(stamp=sample.stamp)]

    return alter


@pytest.mark.parametrize("fault", FAULTS)
def test_backend_holds_after_a_fault_and_names_the_cause(
    fault: str, urdf: Path, stage: StageDocument
) -> None:
    inject, cause = FAULTS[fault]
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, sine, 30)
    inject(peer)
    begun, rate = peer.time, np.array([0.015, 0.012])
    with pytest.raises(BackendError, match="the robot is held: ") as raised:
        run(driven, lambda tick: sine(29) + rate * (tick + 1), 60)
    assert cause in str(raised.value)
    assert driven.supervisor.state is State.HELD
    # A robot that does not follow is found by the distance that it lags, the others by time.
    if fault != "stuck":
        assert peer.commands[-1][0] - begun < 0.15, "the last reference is sent soon"
    assert _within_limits(peer.references)
    steps = np.diff(peer.references, axis=0)
    assert np.abs(steps[-1:]).max() <= 0.05 * PERIOD * VELOCITY.max() + 2.0 * PERIOD


def test_command_of_a_suspended_program_is_stamped_before_the_suspension(
    urdf: Path, stage: StageDocument, monkeypatch: pytest.MonkeyPatch
) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, sine, 30)
    admit, before = driven.supervisor.admit, peer.clock().wall()

    def suspend(reference: np.ndarray, now: float) -> np.ndarray | None:
        admitted = admit(reference, now)
        peer.time += 0.6
        return admitted

    monkeypatch.setattr(driven.supervisor, "admit", suspend)
    driven.apply(sine(30))
    time, command = peer.commands[-1]
    assert time > 0.6
    assert command.stamp == pytest.approx(before, abs=PERIOD)
    assert command.stamp + command.horizon < peer.clock().wall(), "a controller refuses it"


@pytest.mark.parametrize("jump", [-0.3, -0.05, 0.3])
def test_robot_whose_clock_jumps_brakes_without_a_stamp(
    jump: float, urdf: Path, stage: StageDocument
) -> None:
    peer = Peer(alter=lambda sample: [sample._replace(source=7)])
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, sine, 10)
    assert peer.commands[-1][1].stamp > 0.0
    peer.skew, begun = jump, peer.time
    with pytest.raises(BackendError, match="clock"):
        run(driven, lambda tick: sine(10 + tick), 10)
    # The first reference is of the tick in which the clock jumped, and the others brake.
    stamps = [command.stamp for time, command in peer.commands if time >= begun]
    assert stamps[0] > 0.0
    assert set(stamps[1:]) == {0.0}
    assert peer.commands[-1][0] - begun < 0.15


def test_robot_that_another_controller_carries_is_held(urdf: Path, stage: StageDocument) -> None:
    peer, lead = Peer(), 0.12
    driven = backend(peer, urdf)
    begin(driven, stage)
    references = np.zeros(2)

    def law(speed: float) -> np.ndarray:
        # References keep within the lead of measured positions, as those of a program do.
        nonlocal references
        here = driven.observe().positions
        moved = references + np.array([speed, 0.0]) * PERIOD
        references = np.clip(moved, here - lead, here + lead)
        return references

    run(driven, lambda tick: law(0.3), 30)
    peer.moving, start, begun = False, peer.positions.copy(), peer.time
    send, peer.send = peer.send, lambda driver, command: None
    with pytest.raises(BackendError, match=r"'second' moved by 0\.0.* away from its"):
        for _ in range(100):
            peer.positions = start + np.array([0.0, 0.8 * (peer.time - begun)])
            driven.apply(law(0.3))
            driven.step()
    assert peer.positions[1] - start[1] < 0.1
    peer.send = send


class RepeatedDescription(Peer):
    """Peer whose description of the robot comes late."""

    def poll(self) -> Sequence[Sample]:
        samples = list(super().poll())
        return [*samples, DescriptionSample("arm", URDF)] if self.time > 7.0 else samples


def test_examination_waits_for_a_description_that_is_repeated(urdf: Path) -> None:
    publisher = Endpoint("arm", "description", "/description", "a/B", outgoing=False, peers=1)
    for endpoints, obstacles in (([publisher], 0), ([], 1)):
        peer = RepeatedDescription(endpoints=endpoints)
        driven = backend(peer, urdf, description="/description")
        driven.examine(3.0)
        assert len(driven.obstacles()) == obstacles
        assert peer.time == pytest.approx(7.0 if endpoints else 3.0, abs=0.2)


def _within_limits(references: np.ndarray) -> bool:
    inside = (references >= LOWER) & (references <= UPPER)
    speeds = np.diff(references, axis=0) / PERIOD
    # By default the largest speed is reached in 50 ms.
    changes = np.abs(np.diff(speeds, axis=0)) <= VELOCITY * PERIOD / 0.05 + 1e-6
    return bool(inside.all() and (np.abs(speeds) <= VELOCITY + 1e-6).all() and changes.all())


def test_held_robot_is_released_by_a_person_only(urdf: Path, stage: StageDocument) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, sine, 5)
    peer.faults.append(FaultSample("arm", "a publisher has ended"))
    with pytest.raises(BackendError):
        run(driven, sine, 5)
    with pytest.raises(BackendError, match="is held"):
        driven.apply(np.zeros(2))
    driven.attend(Consent())
    with pytest.raises(BackendError, match="a person has to release it"):
        begin(driven, stage)
    refusal = Answers(False)
    driven.attend(refusal)
    with pytest.raises(BackendError, match="a person has to release it"):
        begin(driven, stage)
    assert refusal.questions == ["release it"]
    driven.attend(Answers(True, True))
    begin(driven, stage)
    assert driven.supervisor.state is State.READY


def test_halt_lets_a_consent_begin_the_next_episode(urdf: Path, stage: StageDocument) -> None:
    driven = backend(Peer(), urdf)
    driven.attend(Consent())
    begin(driven, stage)
    run(driven, sine, 20)
    driven.halt()
    assert driven.supervisor.state is State.HELD
    begin(driven, stage)
    assert driven.supervisor.state is State.READY


def test_halt_returns_to_the_measured_positions(urdf: Path, stage: StageDocument) -> None:
    peer = Peer()
    driven = backend(peer, urdf, tracking=0.5)
    begin(driven, stage)
    run(driven, sine, 20)
    peer.moving = False
    stood = peer.positions.copy()
    run(driven, lambda tick: stood + 0.02 * (tick + 1) * np.array([1.0, 0.5]), 4)
    driven.halt()
    assert peer.references[-1] == pytest.approx(stood, abs=1e-3)
    assert _within_limits(peer.references)


def test_program_that_halts_says_so_at_rest(urdf: Path, stage: StageDocument) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, sine, 20)
    driven.halt()
    assert peer.rests == [len(peer.commands)]
    assert (peer.references[-1] == peer.references[-2]).all()


@pytest.mark.parametrize("name", ["silence", "emergency stop", "nan"])
def test_program_that_a_fault_holds_says_nothing(
    name: str, urdf: Path, stage: StageDocument
) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, sine, 5)
    FAULTS[name][0](peer)
    with pytest.raises(BackendError, match="is held"):
        run(driven, sine, 20)
    driven.halt()
    assert peer.rests == []


@pytest.mark.parametrize("person", [RefusingPerson(), Answers(False)])
def test_reset_without_consent_sends_no_reference(
    person: RefusingPerson | Answers, urdf: Path, stage: StageDocument
) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    driven.attend(person)
    with pytest.raises(BackendError):
        begin(driven, stage)
    assert not peer.commands


def _states(peers: int, *types: str) -> Endpoint:
    name = "sensor_msgs/msg/JointState"
    return Endpoint(
        "arm", "states", "/joint_states", name, outgoing=False, peers=peers, foreign_types=types
    )


UNREADY: dict[str, tuple[Peer, str]] = {
    "topic that does not exist": (
        Peer(silent=True, endpoints=[_states(0)]),
        "nothing writes to /joint_states (driver 'arm', states)",
    ),
    "other type": (
        Peer(silent=True, endpoints=[_states(1, "std_msgs/msg/String")]),
        "/joint_states (driver 'arm', states) has the type std_msgs/msg/String, and "
        "sensor_msgs/msg/JointState is needed",
    ),
    "silent topic": (
        Peer(silent=True, endpoints=[_states(1)]),
        "no state of joints 'first', 'second' from driver 'arm' at /joint_states",
    ),
    "missing joint": (
        Peer(alter=lambda s: [_only(s, [0])]),
        "no state of joint 'second' from driver 'arm' at /joint_states",
    ),
    "doubled joint": (
        Peer(alter=lambda s: [_only(s, [0, 1, 0])]),
        "driver 'arm' names joint 'first' twice in one joint state",
    ),
    "pressed stop": (
        Peer(alter=lambda s: [s, StopSample("arm", True)]),
        "the emergency stop of driver 'arm' is pressed",
    ),
    "robot without the joints": (
        Peer(
            alter=lambda s: [
                s, DescriptionSample("arm", '<robot name="other"><link name="a"/></robot>')
            ]
        ),
        "the robot's description has no joints 'first', 'second': another robot?",
    ),
    "robot with other limits": (
        Peer(
            alter=lambda s: [
                s, DescriptionSample("arm", URDF.replace('upper="1"', 'upper="1.5"'))
            ]
        ),
        "joint 'first' has the upper limit 1.5 by the robot, and 1 by its document",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", UNREADY)
def test_unready_robot_has_one_finding_before_anything_moves(
    name: str, urdf: Path, stage: StageDocument
) -> None:
    peer, diagnostic = UNREADY[name]
    with pytest.raises(BackendError) as raised:
        begin(backend(peer, urdf), stage)
    assert str(raised.value).splitlines()[1:] == [f"- {diagnostic}"]
    assert not peer.commands


def test_robot_with_an_emergency_stop_is_ready_once_its_state_is_known(
    urdf: Path, stage: StageDocument
) -> None:
    peer = Peer()
    driven = backend(peer, urdf, stop="/stop")
    with pytest.raises(BackendError, match="no state of the emergency stop from driver 'arm'"):
        begin(driven, stage)
    peer.alter = lambda sample: [sample, StopSample("arm", False)]
    begin(driven, stage)
    assert driven.supervisor.state is State.READY
    # A stop may be published when it changes only.
    peer.alter = lambda sample: [sample]
    begin(driven, stage)
    assert driven.supervisor.state is State.READY


def test_not_ready_names_every_obstacle(urdf: Path, stage: StageDocument) -> None:
    described = URDF.replace('upper="1"', 'upper="1.5"')
    peer = Peer(
        alter=lambda s: [_only(s, [0]), DescriptionSample("arm", described)],
        endpoints=[
            Endpoint(
                "arm",
                "commands",
                "/commands",
                "a/msg/B",
                outgoing=True,
                peers=0,
                rivals=("process 7",),
            )
        ],
    )
    driven = backend(peer, urdf, stop="/stop")
    with pytest.raises(BackendError) as raised:
        begin(driven, stage)
    lines = str(raised.value).splitlines()
    assert lines == [
        "robot 'rail' is not ready:",
        "- nothing listens to /commands (driver 'arm', commands)",
        "- another commander writes to /commands (driver 'arm', commands): process 7",
        "- joint 'first' has the upper limit 1.5 by the robot, and 1 by its document",
        "- no state of joint 'second' from driver 'arm' at /joint_states",
        "- no state of the emergency stop from driver 'arm' at /stop",
    ]
    assert not peer.commands


def test_first_reference_far_from_the_robot_is_refused(urdf: Path, stage: StageDocument) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    with pytest.raises(BackendError, match=r"the first reference of joint 'second' is 0\.500 from"):
        driven.apply(np.array([0.0, 0.5]))
    assert not peer.commands


def test_robot_is_claimed_after_consent_and_not_by_examining(
    urdf: Path, stage: StageDocument
) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    driven.examine(0.3)
    driven.attend(Answers(False))
    with pytest.raises(BackendError, match="not set up"):
        driven.reset(stage, None, np.random.default_rng(0))
    assert peer.claims == 0
    driven.attend(Answers(True))
    driven.reset(stage, None, np.random.default_rng(0))
    assert peer.claims == 1


def test_joint_order_of_messages_does_not_matter(urdf: Path, stage: StageDocument) -> None:
    peer = Peer(positions=np.array([0.2, -0.4]), alter=lambda s: [_only(s, [1, 0])])
    driven = backend(peer, urdf)
    begin(driven, stage)
    assert driven.observe().positions == pytest.approx([0.2, -0.4], abs=1e-5)


def test_driver_names_of_joints_are_used_both_ways(urdf: Path, stage: StageDocument) -> None:
    def rename(sample: JointSample) -> list[JointSample]:
        return [sample._replace(names=("j1", "j2"))]

    peer = Peer(alter=rename)
    driven = backend(peer, urdf, joints={"first": "j1", "second": "j2"})
    begin(driven, stage)
    driven.apply(np.zeros(2))
    assert peer.commands[-1][1].names == ("j1", "j2")


def test_suspended_process_holds(urdf: Path, stage: StageDocument) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, sine, 5)
    peer.time += 0.4
    with pytest.raises(BackendError, match="suspended for 4"):
        run(driven, sine, 3)


@pytest.mark.parametrize("pause", [0.06, 0.2, 0.4])
def test_long_tick_of_a_standing_robot_continues(
    pause: float, urdf: Path, stage: StageDocument
) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, lambda tick: np.zeros(2), 5)
    assert driven.deadline is not None and driven.deadline > pause
    peer.sleep(pause)
    run(driven, sine, 20)
    assert driven.supervisor.state is State.RUNNING


@pytest.mark.parametrize("name", ["silence", "emergency stop", "nan", "other robot"])
def test_fault_in_a_long_tick_holds_before_any_reference(
    name: str, urdf: Path, stage: StageDocument
) -> None:
    fault, sentence = FAULTS[name]
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, lambda tick: np.zeros(2), 5)
    fault(peer)
    peer.sleep(0.2)
    sent = len(peer.commands)
    with pytest.raises(BackendError, match=sentence):
        driven.apply(sine(1))
    assert len(peer.commands) == sent


def test_robot_returns_to_its_start_before_the_next_episode(
    urdf: Path, stage: StageDocument
) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, lambda tick: 0.01 * tick * np.array([1.0, -0.5]), 60)
    driven.halt()
    assert np.abs(peer.positions).max() > 0.4
    sent = len(peer.commands)
    begin(driven, stage)
    assert peer.positions == pytest.approx(np.zeros(2), abs=0.05)
    assert driven.supervisor.state is State.READY
    assert driven.observe().time == pytest.approx(0.0, abs=PERIOD)
    assert _within_limits(peer.references[sent:])
    sent = len(peer.commands)
    begin(driven, stage)
    assert len(peer.commands) == sent, "a robot at its start does not move"


def test_robot_whose_return_is_refused_stays(urdf: Path, stage: StageDocument) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, lambda tick: 0.01 * tick * np.ones(2), 60)
    driven.halt()
    sent = len(peer.commands)
    answers = Answers(True, False)
    driven.attend(answers)
    with pytest.raises(BackendError, match=r"joint 'first' by 0\.5.*on the way that it came"):
        begin(driven, stage)
    assert answers.questions == ["release it", "may it return"]
    assert len(peer.commands) == sent


def test_fault_on_the_way_back_holds_the_robot(urdf: Path, stage: StageDocument) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, lambda tick: 0.01 * tick * np.ones(2), 60)
    sent = len(peer.commands)

    def fail(sample: JointSample) -> list[JointSample]:
        return [] if len(peer.commands) > sent + 15 else [sample]

    peer.alter = fail
    with pytest.raises(BackendError, match="the robot is held: no new state"):
        begin(driven, stage)
    assert np.abs(peer.positions).min() > 0.1


class StagingPeer(Peer):
    """Robot whose simulation sets up the stage at the third request."""

    stages = True

    def __init__(self, problem: str = "", patience: int = 3) -> None:
        super().__init__()
        self.problem, self.patience = problem, patience
        self.asked: list[tuple[Setup, np.ndarray]] = []

    def ask(self, setup: Setup) -> None:
        self.asked.append((setup, self.positions.copy()))

    def answer(self) -> str | None:
        return self.problem if len(self.asked) >= self.patience else None


def test_stage_is_requested_where_the_robot_starts(urdf: Path, stage: StageDocument) -> None:
    peer = StagingPeer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    run(driven, lambda tick: 0.01 * tick * np.ones(2), 60)
    peer.asked.clear()
    rng = np.random.default_rng(7)
    drawn = rng.bit_generator.state
    driven.reset(stage, None, rng)
    assert len(peer.asked) == 3, "a request is repeated until it is answered"
    for setup, positions in peer.asked:
        assert setup == Setup("rail", stage, None, drawn)
        assert positions == pytest.approx(np.zeros(2), abs=0.05)


@pytest.mark.parametrize(
    ("peer", "words"),
    [(StagingPeer("no room"), "no room"), (StagingPeer(patience=10**6), "no answer for 30 s")],
)
def test_stage_that_is_not_set_up_ends_the_episode(
    peer: StagingPeer, words: str, urdf: Path, stage: StageDocument
) -> None:
    driven = backend(peer, urdf)
    with pytest.raises(BackendError, match=f"the stage is not set up: {words}"):
        begin(driven, stage)
    assert not peer.commands


events = st.sampled_from([*FAULTS, "none", "halt", "jump", "nan reference", "huge reference"])


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(events, st.integers(1, 12)), min_size=1, max_size=8))
def test_no_sequence_of_faults_moves_a_held_robot_or_breaks_a_limit(
    urdf: Path, stage: StageDocument, sequence: list[tuple[str, int]]
) -> None:
    peer = Peer()
    driven = backend(peer, urdf)
    begin(driven, stage)
    held_at: int | None = None
    for event, ticks in sequence:
        reference = _event(event, peer, driven)
        for _ in range(ticks):
            try:
                driven.apply(reference)
                driven.step()
            except BackendError:
                assert driven.supervisor.state is State.HELD
                assert driven.supervisor.cause
        if driven.supervisor.state is State.HELD:
            held_at = len(peer.commands) if held_at is None else held_at
            assert len(peer.commands) == held_at, "a held robot gets no more references"
    assert _within_limits(peer.references)
    assert np.isfinite(peer.references).all()


def _event(event: str, peer: Peer, driven: DrivenBackend) -> np.ndarray:
    """Let an event happen; return the references that follow."""
    if event in FAULTS:
        FAULTS[event][0](peer)
    elif event == "halt":
        driven.halt()
    elif event == "jump":
        peer.time += 0.3
    at = driven.supervisor.limiter.positions
    wild = {"nan reference": math.nan, "huge reference": 1e9}
    return at + wild.get(event, 0.03)


def test_observation_has_no_more_than_the_contract(urdf: Path, stage: StageDocument) -> None:
    driven = backend(Peer(), urdf)
    begin(driven, stage)
    fields = {each.name for each in dataclasses.fields(driven.observe())}
    assert fields >= {"time", "positions", "velocities", "loads", "images"}
