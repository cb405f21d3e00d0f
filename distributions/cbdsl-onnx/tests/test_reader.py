"""Readers of networks: chunks at their rate, deadlines, histories and faulty outputs."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from cbdsl.extend.document import Origin, Resource
from cbdsl.extend.source import POSITION, Reading
from cbdsl.types.resource import Tip

pytest.importorskip("onnxruntime")
from cbdsl_onnx.inference import Inference
from cbdsl_onnx.plan import InputPlan, NetworkPlan, Normalisation, OutputPlan
from cbdsl_onnx.reader import NetworkReader

HERE = Resource("arm.position", POSITION, Origin.KINEMATICS, Tip("arm", "position"))
NONE = Normalisation((), ())


def plan(
    gives: str = "target",
    steps: int = 1,
    executed: int | None = None,
    period: float = 0.1,
    deadline: float = 0.02,
    history: int = 1,
) -> NetworkPlan:
    shape = (1, history, 3)
    tensor = InputPlan("x", (HERE,), NONE, history, shape, "float32")
    output = OutputPlan("y", HERE, gives, NONE, steps, executed or steps)
    return NetworkPlan("none", "", (tensor,), output, period, deadline)


@dataclass
class World:
    """Signals of one position, which the test moves."""

    time: float = 0.0
    is_awaited: bool = True
    clock: NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    place: NDArray[np.float64] | None = field(default_factory=lambda: np.zeros(3))

    def bind(self, resource: Resource) -> int:
        return 0

    def read(self, resource: Resource) -> Reading | None:
        return None if self.place is None else Reading(self.place.copy(), None, 0)

    def at(self, tick: int, period: float) -> None:
        self.clock[0], self.time = tick + 1, tick * period


class Scripted:
    """Inference whose n-th output is n in all components, plus a tenth for each later action."""

    is_busy = False

    def __init__(self, size: int) -> None:
        self.count, self.size, self.feeds = 0, size, []  # type: ignore[var-annotated]
        self.fails = False

    def request(self, feeds: dict[str, NDArray[Any]]) -> None:
        self.feeds.append(feeds["x"])

    def receive(self, deadline: float) -> NDArray[Any] | None:
        self.count += 1
        chunk = self.count + 0.01 * np.arange(self.size)[:, None] + np.zeros(3)
        return None if self.fails else chunk

    def forget(self) -> None:
        pass


@settings(max_examples=80, deadline=None)
@given(st.data())
def test_reader_plays_each_action_for_its_period_without_a_gap(data: st.DataObject) -> None:
    tick = data.draw(st.sampled_from([0.002, 1 / 120, 0.01, 0.02]))
    steps = data.draw(st.integers(1, 6))
    executed = data.draw(st.integers(1, steps))
    period = data.draw(st.floats(1.0, 12.0)) * tick
    # A request waits for a tick, so that an output needs up to a tick more than its deadline.
    deadline = tick * data.draw(st.floats(0.01, max(executed * period / tick - 1.0, 0.02)))
    world, inference = World(), Scripted(steps)
    network = plan(steps=steps, executed=executed, period=period, deadline=deadline)
    read = NetworkReader(network, world, inference)  # type: ignore[arg-type]
    firsts: dict[tuple[int, int], float] = {}
    for number in range(400):
        world.at(number, tick)
        if (reading := read()) is not None:
            count, index = divmod(round(100 * float(reading.value[0])), 100)
            if count > 0:  # it stays until the first output
                firsts.setdefault((count, index), world.time)
        assert reading is not None, f"undefined at {world.time}"
    assert len(firsts) > 10
    for (count, index), first in firsts.items():
        begin = deadline + (count - 1) * executed * period
        assert abs(first - (begin + index * period)) <= 2 * tick, (count, index)


def test_reader_of_a_failed_output_is_undefined_until_the_next_one() -> None:
    world, inference = World(), Scripted(1)
    read = NetworkReader(plan(period=0.1, deadline=0.05), world, inference)  # type: ignore[arg-type]
    defined = []
    for number in range(60):
        inference.fails = 15 <= number < 30
        world.at(number, 0.01)
        defined.append(read() is not None)
    # Outputs are due every 0.1 s from 0.05 s on; those of 0.15 s and 0.25 s fail.
    assert [each for each, is_defined in enumerate(defined) if not is_defined] == [*range(15, 35)]


def test_reader_of_undefined_inputs_is_undefined_and_begins_again() -> None:
    world, inference = World(), Scripted(1)
    network = plan(period=0.05, deadline=0.01, history=3)
    read = NetworkReader(network, world, inference)  # type: ignore[arg-type]
    for number in range(40):
        world.at(number, 0.01)
        world.place = None if 10 <= number < 20 else np.full(3, 0.01 * number)
        read()
    first = [feed[0, :, 0].astype(float).round(2).tolist() for feed in inference.feeds]
    assert first[:2] == [[0.0, 0.0, 0.0], [0.0, 0.0, 0.05]]
    assert first[2:4] == [[0.2, 0.2, 0.2], [0.2, 0.2, 0.25]] and first[4] == [0.2, 0.25, 0.3]


@pytest.mark.parametrize(("gives", "expected"), [("displacement", 1.0), ("velocity", 1.5)])
def test_reader_adds_a_displacement_where_its_action_begins(gives: str, expected: float) -> None:
    world, inference = World(), Scripted(1)
    read = NetworkReader(plan(gives, period=0.1, deadline=0.0), world, inference)  # type: ignore[arg-type]
    world.at(0, 0.01)
    read()
    world.at(1, 0.01)
    assert (begun := read()) is not None and begun.value[0] == pytest.approx(1.0)
    world.place = np.full(3, 0.5)
    world.at(2, 0.01)
    assert (reading := read()) is not None and reading.value[0] == pytest.approx(expected)


class Slow:
    """Session whose outputs take a time, s, or are not finite."""

    def __init__(self, duration: float, value: float = 1.0) -> None:
        self.duration, self.value = duration, value

    def run(self, names: list[str], feeds: Any, options: Any) -> list[NDArray[np.float32]]:
        end = time.monotonic() + self.duration
        while time.monotonic() < end and not options.terminate:
            time.sleep(1e-3)
        return [np.full((1, 3), self.value, np.float32)]


def _inference(session: Slow) -> Inference:
    from concurrent.futures import ThreadPoolExecutor

    inference = Inference.__new__(Inference)
    inference._session, inference._output = session, "y"
    inference._thread, inference._request = ThreadPoolExecutor(1), None
    inference._seconds = []
    return inference


def test_inference_of_a_robot_is_late_without_waiting_and_stops() -> None:
    inference = _inference(Slow(30.0))
    inference.request({})
    begun = time.monotonic()
    assert inference.receive(0) is None and inference.is_busy
    assert time.monotonic() - begun < 5.0
    inference._thread.shutdown()  # the request ended
    assert time.monotonic() - begun < 10.0


def test_inference_after_an_interrupted_episode_takes_its_next_request() -> None:
    inference = _inference(Slow(30.0))
    inference.request({})
    inference.forget()
    assert not inference.is_busy
    inference._session = Slow(0.0)
    inference.request({})
    assert inference.receive(5.0) is not None


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_inference_without_finite_numbers_gives_none(value: float) -> None:
    inference = _inference(Slow(0.0, value))
    inference.request({})
    assert inference.receive(5.0) is None


class Busy(Slow):
    """Session whose outputs take processor time, s, one after another."""

    def __init__(self, *durations: float) -> None:
        super().__init__(0.0)
        self.durations = list(durations)

    def run(self, names: list[str], feeds: Any, options: Any) -> list[NDArray[np.float32]]:
        begun, duration = time.thread_time(), self.durations.pop(0)
        while time.thread_time() - begun < duration:
            pass
        return super().run(names, feeds, options)


def test_inference_of_a_starved_thread_gives_its_output_in_a_simulation() -> None:
    starved = _inference(Slow(1.5))
    starved.request({})
    assert starved.receive(0.02) is not None


def test_inference_that_stalls_once_gives_all_outputs_in_a_simulation() -> None:
    inference = _inference(Busy(0.06, 0.0, 0.06, 0.06))
    for _ in range(4):
        inference.request({})
        assert inference.receive(0.03) is not None


def test_inference_of_a_network_that_is_always_late_is_an_error_in_a_simulation() -> None:
    inference = _inference(Busy(0.03, 0.04, 0.05))
    for is_last in (False, False, True):
        inference.request({})
        if is_last:
            with pytest.raises(ValueError, match="deadline is 20 ms"):
                inference.receive(0.02)
        else:
            assert inference.receive(0.02) is not None


def test_inference_without_an_end_is_an_error_in_a_simulation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("cbdsl_onnx.inference._LONGEST", 0.1)
    inference = _inference(Slow(30.0))
    inference.request({})
    with pytest.raises(ValueError, match=r"more than 0\.1 s"):
        inference.receive(0.02)
    inference._thread.shutdown()  # the request ended


def test_inference_in_time_gives_its_output() -> None:
    inference = _inference(Slow(0.0))
    inference.request({})
    output = inference.receive(5.0)
    assert output is not None and output.tolist() == [[1.0, 1.0, 1.0]]


def test_reader_of_a_robot_in_real_time_never_waits_for_an_output() -> None:
    world, inference = World(is_awaited=False), _inference(Slow(30.0))
    read = NetworkReader(plan(deadline=5.0, period=10.0), world, inference)  # type: ignore[arg-type]
    begun, defined = time.monotonic(), []
    for number in range(3):
        world.at(number, 4.0)
        defined.append(read() is not None)
    assert time.monotonic() - begun < 2.0
    assert defined == [True, True, False]  # it is due at 5 s
    inference._thread.shutdown()


def test_reader_of_an_idle_controller_forgets_its_chunk() -> None:
    world, inference = World(), Scripted(9)
    read = NetworkReader(plan(steps=9, period=0.05, deadline=0.01), world, inference)  # type: ignore[arg-type]
    for number in (0, 1, 2, 5, 6):
        world.at(number, 0.01)
        values = read()
        assert values is not None
        # Where it is at first, and then the outputs 1 and 2.
        assert values.value[0] == {0: 0.0, 1: 1.0, 2: 1.0, 5: 0.0, 6: 2.0}[number]
