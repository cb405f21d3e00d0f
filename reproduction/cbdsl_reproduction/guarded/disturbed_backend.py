"""Backend with noise on its sensors and pushes against its arm."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cbdsl.extend.backend import Floats, Loads, Observation, StageDocument

# Standard deviations of joint positions, rad, velocities, rad/s, and forces, N.
_POSITIONS, _VELOCITIES, _FORCES = 1e-3, 1e-2, 0.2
# Number of pushes, the time in which they begin, s, their length, s, and their forces, N.
_PUSHES, _BEGIN, _LENGTH, _LEAST, _MOST = 4, (0.5, 9.0), 0.2, 5.0, 20.0


class LinkPush(NamedTuple):
    """Push against a link: its begin, s, and its force in the world frame, N, shape (3,)."""

    link: str
    begin: float
    force: Floats


class DisturbedBackend:
    """Robot with noisy sensors that is pushed; see ``cbdsl.extend.backend.Backend``.

    Args:
        backend: Simulated backend, whose engine can push links.
        links: Names of the links to push.
    """

    def __init__(self, backend: Any, links: Sequence[str]) -> None:
        self._backend, self._links = backend, links
        self.renderer: str = backend.renderer
        self.control_period: float = backend.control_period
        self.deadline: float | None = None

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Begin an episode; the world's draws are those without disturbances."""
        (self._rng,) = rng.spawn(1)
        self.pushes = tuple(self._drawn() for _ in range(_PUSHES))
        name: str = self._backend.reset(stage, context, rng, channels)
        self._tick, self._observation = 0, self._noisy(self._backend.observe())
        return name

    def _drawn(self) -> LinkPush:
        direction = self._rng.normal(size=3)
        force = self._rng.uniform(_LEAST, _MOST) * direction / np.linalg.norm(direction)
        link = self._links[int(self._rng.integers(len(self._links)))]
        return LinkPush(link, float(self._rng.uniform(*_BEGIN)), force)

    def observe(self) -> Observation:
        """Return the current sensor values."""
        return self._observation

    def _noisy(self, seen: Observation) -> Observation:
        draw = self._rng.normal
        wrenches = np.array([*seen.loads.values()])
        wrenches[:, :3] += draw(0.0, _FORCES, (len(wrenches), 3))
        return replace(
            seen,
            positions=seen.positions + draw(0.0, _POSITIONS, seen.positions.shape),
            velocities=seen.velocities + draw(0.0, _VELOCITIES, seen.velocities.shape),
            loads=Loads(tuple(seen.loads), wrenches),
        )

    def apply(self, reference: Floats) -> None:
        """Set the references of the actuated joints, rad, shape (n,)."""
        self._backend.apply(reference)

    def step(self) -> None:
        """Let one control period pass."""
        now = self._tick * self.control_period
        forces = {link: np.zeros(3) for link in self._links}
        for push in self.pushes:
            if push.begin <= now < push.begin + _LENGTH:
                forces[push.link] = forces[push.link] + push.force
        for link, force in forces.items():
            self._backend.truth.push(link, force)
        self._backend.step()
        self._tick += 1
        self._observation = self._noisy(self._backend.observe())

    def halt(self) -> None:
        """Freeze the references at the measured positions."""
        self._backend.halt()

    def close(self) -> None:
        """Free the world."""
        self._backend.close()
