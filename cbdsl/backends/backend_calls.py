"""Calls of a backend whose failures name it: backends come from other packages, too."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from cbdsl.backends.backend import Backend, BackendError, ResumableBackend, name_of
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.observation import Observation


class BackendCalls:
    """Calls of a backend, with its answers checked against its contract.

    Args:
        backend: Backend, of any package.
        robot: Robot that it embodies.

    Attributes:
        backend: Backend that is called.
        name: Name of the backend in messages.

    Raises:
        BackendError: The control period or the deadline is not a time.
    """

    def __init__(self, backend: Backend, robot: RobotDocument) -> None:
        self.backend, self.name = backend, name_of(backend)
        joints = sum(len(effector.joints) for effector in robot.effectors.values())
        self._shape, self._cameras = (joints,), frozenset(robot.cameras)
        self._time = -math.inf
        period, deadline = backend.control_period, backend.deadline
        if not _is_finite(period) or period <= 0:
            raise BackendError(
                f"backend '{self.name}' has the control period {period!r}, not a time above 0 s"
            )
        if deadline is not None and not (isinstance(deadline, float | int) and deadline >= 0):
            raise BackendError(
                f"backend '{self.name}' has the deadline {deadline!r}, not None or a time in s"
            )

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None,
    ) -> str:
        """Begin an episode; see ``Backend.reset``."""
        with self._named("reset"):
            drawn = self.backend.reset(stage, context, rng, channels)
        if not isinstance(drawn, str):
            raise self._broken("reset", f"returned {drawn!r}, not the name of a context")
        self._time = -math.inf
        return drawn

    def resume(
        self,
        stage: StageDocument,
        context: str | None,
        channels: Collection[str] | None,
        *,
        undisturbed: bool,
    ) -> str | None:
        """Begin an episode in the world as it is; see ``ResumableBackend.resume``.

        Raises:
            BackendError: The backend offers no such world, or fails.
        """
        backend = self.backend
        if not isinstance(backend, ResumableBackend):
            raise BackendError(
                f"stage '{stage.name}' has a persistent world, and this backend offers none"
            )
        self._time = -math.inf
        with self._named("resume"):
            # The argument is passed only if it is true, so that backends without it work.
            if undisturbed:
                return backend.resume(stage, context, channels, undisturbed=True)
            return backend.resume(stage, context, channels)

    def observe(self) -> Observation:
        """Return the sensors' values, checked in time, shape and type; see ``Backend.observe``."""
        with self._named("observe"):
            observation = self.backend.observe()
        fault = self._fault(observation)
        if fault is not None:
            raise self._broken("observe", fault)
        self._time = observation.time
        return observation

    def apply(self, reference: Floats) -> None:
        """Set the joints' references; see ``Backend.apply``."""
        with self._named("apply"):
            self.backend.apply(reference)

    def step(self) -> None:
        """Let one control period pass; see ``Backend.step``."""
        with self._named("step"):
            self.backend.step()

    def halt(self, cause: BaseException) -> None:
        """Halt the robot; a failure to do so becomes a note of the exception that ends an episode.

        An interrupt in the middle of it does not leave the robot moving: it is halted again.

        Args:
            cause: Exception that ends the episode.

        Raises:
            BackendError: The robot cannot be halted, and nothing else went wrong.
        """
        failure = self._failed_halt()
        # A second Ctrl-C while the robot is halted must not leave it moving.
        if isinstance(failure, KeyboardInterrupt):
            failure = self._failed_halt()
        if failure is None:
            return
        warning = f"the robot may still move: {str(failure) or type(failure).__name__}"
        if isinstance(cause, GeneratorExit):  # notes of a closed episode are not shown
            raise BackendError(warning) from failure
        cause.add_note(warning)

    def _failed_halt(self) -> BaseException | None:
        try:
            with self._named("halt"):
                self.backend.halt()
        except BaseException as failure:
            return failure
        return None

    @contextmanager
    def _named(self, method: str) -> Iterator[None]:
        """Raise the backend's own exceptions with its name; pass those for users unchanged."""
        try:
            yield
        except UsageError:
            raise
        except Exception as error:
            reason = f"{type(error).__name__}: {error}".rstrip(": ")
            raise self._broken(method, f"raised {reason}") from error

    def _broken(self, method: str, fault: str) -> BackendError:
        return BackendError(f"backend '{self.name}': {method}() {fault}")

    def _fault(self, observation: object) -> str | None:
        """Return how an observation breaks the contract, if it does."""
        if not isinstance(observation, Observation):
            return f"returned a {type(observation).__name__}, not an Observation"
        time = observation.time
        if not _is_finite(time):
            return f"gave the time {time!r}, which is not finite"
        if time < self._time:
            return f"gave the time {time:g} s after {self._time:g} s"
        if observation.exposed is not None and not _is_finite(observation.exposed):
            return f"gave the time {observation.exposed!r} of its images, which is not finite"
        joints = {"positions": observation.positions, "velocities": observation.velocities}
        if observation.efforts is not None:
            joints["efforts"] = observation.efforts
        for what, values in joints.items():
            if not _is_array(values, self._shape):
                return f"gave {what} as {_form(values)}, not as floats of shape {self._shape}"
        return self._fault_of_cells(observation) or self._fault_of_images(observation)

    def _fault_of_cells(self, observation: Observation) -> str | None:
        if not isinstance(observation.loads, Mapping):
            return f"gave loads as {_form(observation.loads)}, not by (hand, finger)"
        for cell, wrench in observation.loads.items():
            if not _is_array(wrench, (6,)):
                return f"gave the load of {cell} as {_form(wrench)}, not as floats of shape (6,)"
        return None

    def _fault_of_images(self, observation: Observation) -> str | None:
        for camera, image in observation.images.items():
            if camera not in self._cameras:
                return f"gave an image of '{camera}', which is not a camera of the robot"
            if getattr(image, "dtype", None) != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
                return (
                    f"gave the image of '{camera}' as {_form(image)}, not as bytes of shape "
                    "(height, width, 3)"
                )
        return None


def _is_finite(value: Any) -> bool:
    return isinstance(value, float | int | np.floating | np.integer) and math.isfinite(value)


def _is_array(value: Any, shape: tuple[int, ...]) -> bool:
    return isinstance(value, np.ndarray) and value.dtype == np.float64 and value.shape == shape


def _form(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"{value.dtype} of shape {value.shape}"
    return f"a {type(value).__name__}"


@contextmanager
def closing_backend(backend: Backend) -> Iterator[None]:
    """Close a backend at the end; a failure to close hides no earlier exception.

    Raises:
        BackendError: It cannot be closed, and nothing else went wrong.
    """
    try:
        yield
    except BaseException as cause:
        try:
            backend.close()
        except Exception as failure:
            cause.add_note(f"{_unclosed(backend)}: {failure}")
        raise
    try:
        backend.close()
    except UsageError:
        raise
    except Exception as failure:
        raise BackendError(f"{_unclosed(backend)}: {failure}") from failure


def _unclosed(backend: Backend) -> str:
    return f"backend '{name_of(backend)}' cannot be closed"
