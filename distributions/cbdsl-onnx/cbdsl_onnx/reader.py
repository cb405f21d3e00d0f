"""Reader of a network's signal: observations, requests, and the action of this tick.

Times are logical: an output takes effect exactly ``deadline`` after its observation, however
fast the computer is. Simulated and real runs thus have the same delays, and repeat.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.document import ModelSignal, Resource
from cbdsl.extend.source import Reading, Signals
from cbdsl_onnx.camera_images import CameraImages, pixels
from cbdsl_onnx.inference import Inference
from cbdsl_onnx.plan import InputPlan, NetworkPlan, Normalisation

Numbers = NDArray[np.float64]
Observed = NDArray[Any]
"""Observation of one input: numbers, shape (m,), or pixels."""

#: Share of a period within which times are equal.
_ROUNDING = 1e-6


class _Chunk(NamedTuple):
    """Actions of one output, shape (steps, m), from the moment ``begin``, s."""

    begin: float
    actions: Numbers


def reader(signal: ModelSignal, signals: Signals) -> Callable[[], Reading | None]:
    """Return the reader of a network's signal, called in every tick in which it is needed."""
    assert isinstance(signal.data, NetworkPlan)
    cameras = [each.camera for each in signal.data.inputs if each.camera]
    images = CameraImages(signal.model, cameras, signals)
    return NetworkReader(signal.data, signals, Inference(signal.data), images)


class NetworkReader:
    """Reader of a network's signal; see the module."""

    def __init__(
        self,
        plan: NetworkPlan,
        signals: Signals,
        inference: Inference,
        images: CameraImages | None = None,
    ) -> None:
        self._plan, self._signals, self._inference = plan, signals, inference
        self._images = images
        for resource in (
            plan.output.feedback,
            *(r for each in plan.inputs for r in each.resources),
        ):
            signals.bind(resource)
        self._tick = 0
        self._reading: Reading | None = None
        self._begin()

    def __call__(self) -> Reading | None:
        tick = int(self._signals.clock[0])
        if tick != self._tick:
            # A controller that was idle begins again, as in a new episode.
            if tick != self._tick + 1:
                self._inference.forget()
                self._begin()
            self._tick, self._reading = tick, self._read(self._signals.time)
        return self._reading

    def _begin(self) -> None:
        self._history = [deque[Observed](maxlen=each.history) for each in self._plan.inputs]
        self._next: float | None = None
        self._wait = 0
        self._due: float | None = None
        self._chunk: _Chunk | None = None
        self._is_first = True
        self._anchor: tuple[int, Numbers | None] = -1, None

    def _read(self, now: float) -> Reading | None:
        slack = _ROUNDING * self._plan.period
        if self._due is not None and now >= self._due - slack:
            self._receive(self._due)
        if self._next is None or now >= self._next - slack:
            self._observe(now)
        target = self._target(now + slack)
        return None if target is None else Reading(target, None, self._tick)

    def _receive(self, due: float) -> None:
        # A robot does not wait: its deadline has passed by the time of the clock, too.
        patience = self._plan.deadline if self._signals.is_awaited else 0.0
        plan, output = self._plan.output, self._inference.receive(patience)
        self._due, self._anchor, self._is_first = None, (-1, None), False
        if output is None:
            self._chunk = None
            return
        actions = _restored(output.astype(float).reshape(plan.steps, -1), plan.scale)
        self._chunk = _Chunk(due, actions)

    def _observe(self, now: float) -> None:
        """Observe the inputs, once a period, and request an output when the next one is due."""
        period = self._plan.period
        if self._next is None:
            self._next = now
        self._next += period
        self._wait = max(self._wait - 1, 0)
        rows = [self._observed(each) for each in self._plan.inputs]
        if any(row is None for row in rows):
            for history in self._history:
                history.clear()
            return
        for history, row in zip(self._history, rows, strict=True):
            assert row is not None
            history.append(row)
        if self._wait == 0 and self._due is None and not self._inference.is_busy:
            feeds = zip(self._plan.inputs, self._history, strict=True)
            self._inference.request({each.name: _tensor(each, rows) for each, rows in feeds})
            self._due, self._wait = now + self._plan.deadline, self._plan.output.executed

    def _target(self, now: float) -> Numbers | None:
        """Return the value that the action of a moment asks the feedback to have."""
        plan = self._plan.output
        if self._chunk is None:
            # Until the first output is due, the feedback stays where it is.
            is_awaited = self._is_first and self._due is not None
            return self._values((plan.feedback,)) if is_awaited else None
        index = math.floor((now - self._chunk.begin) / self._plan.period)
        if index >= plan.steps and self._due is None:
            self._chunk = None
            return None
        # Between ticks, the last action may end before the output that was requested meanwhile.
        index = min(index, plan.steps - 1)
        action: Numbers = self._chunk.actions[index]
        if plan.gives == "target":
            return action
        # A displacement is from the value at which its action begins, a velocity from the present.
        if self._anchor[0] != index or plan.gives == "velocity":
            self._anchor = index, self._values((plan.feedback,))
        base = self._anchor[1]
        return None if base is None else base + action

    def _observed(self, tensor: InputPlan) -> Observed | None:
        """Return an observation of an input, ``None`` while it is undefined."""
        if tensor.camera:
            image = None if self._images is None else self._images.read(tensor.camera)
            return None if image is None else pixels(image, tensor)
        row = self._values(tensor.resources)
        return None if row is None else _normalised(row, tensor.scale)

    def _values(self, resources: tuple[Resource, ...]) -> Numbers | None:
        """Return the components of signals in turn, ``None`` while one is undefined."""
        values = []
        for resource in resources:
            reading = self._signals.read(resource)
            if reading is None:
                return None
            value = reading.value
            if value.shape == (4, 4):
                value = np.concatenate([value[:3, 3], value[:3, :3].ravel()])
            values.append(value.ravel())
        return np.concatenate(values)


def _normalised(row: Numbers, scale: Normalisation) -> Numbers:
    centred = row - np.array(scale.mean) if scale.mean else row
    return centred / np.array(scale.deviation) if scale.deviation else centred


def _restored(rows: Numbers, scale: Normalisation) -> Numbers:
    stretched = rows * np.array(scale.deviation) if scale.deviation else rows
    return stretched + np.array(scale.mean) if scale.mean else stretched


def _tensor(plan: InputPlan, rows: deque[Observed]) -> NDArray[np.generic]:
    """Return the observations as a tensor; the first one is repeated until there are enough."""
    padded = [rows[0]] * (plan.history - len(rows)) + list(rows)
    return np.concatenate(padded).reshape(plan.shape).astype(plan.dtype)
