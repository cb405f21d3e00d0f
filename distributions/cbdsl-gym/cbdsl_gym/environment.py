"""Environment of Gymnasium: the actions are a program's compositions, states their predicates."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Discrete, MultiDiscrete
from numpy.typing import NDArray

from cbdsl import EpisodeResult, RunRequest, Transition, open_robot
from cbdsl.api.program import DeferredPolicy
from cbdsl.api.sensing import Tick

#: Predicates, at the index that stands for them in an observation.
LETTERS = "X-01"
_SEEDS = 2**31

States = NDArray[np.int64]


# Model: a semi-Markov decision process. The state is the tuple of predicates of the members, each
# X, -, 0 or 1 (Eq 4.1). An action runs for many control ticks, until the state changes, and its
# duration does not enter the reward. The assumption is that the predicates suffice to choose an
# action. It breaks if equal states hide different situations, such as two objects at different
# distances.
class ProgramEnvironment(gymnasium.Env[States, np.int64]):
    """Program as an environment: the agent chooses the next action at each change of state.

    A step runs an action until the state changes, or until it ran out of time. Its reward is the
    reward of the program (Eq 4.4), and at least 1 for a state of success. An episode terminates
    with the reward, or with a state of success or failure. The program's limits truncate it.

    ``gymnasium.make("cbdsl_gym:cbdsl/Program-v0", program="reach")`` makes one, too.

    Args:
        program: Result of ``load``, or a file or name for it.
        backend, cameras: Backend and cameras, as for ``open_robot``.
        context: Context of the stage; drawn by share if ``None``.

    Attributes:
        actions: Names of the program's actions, in order of their numbers.
        members: Names of the controllers and programs, in order of their places in an observation.
        observation_space: Predicates by their numbers in ``LETTERS``, shape (members,).
        action_space: Numbers of the actions.

    Raises:
        DiagnosticsError, UsageError: Same conditions as for ``open_robot``.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 (as the base class has it)

    def __init__(
        self,
        program: str | Path | RunRequest,
        *,
        backend: str = "kinematic",
        cameras: str | None = None,
        context: str | None = None,
    ) -> None:
        self._open, self._is_open = ExitStack(), True
        self._robot = self._open.enter_context(
            open_robot(program, backend=backend, cameras=cameras)
        )
        checked = self._robot.request.program
        self._context = context
        self.actions = tuple(action.name for action in checked.actions)
        self.members = tuple(checked.members)
        self.observation_space = MultiDiscrete([len(LETTERS)] * len(self.members))
        self.action_space = Discrete(len(self.actions))
        self._policy = DeferredPolicy()
        self._ticks: Generator[Tick, None, EpisodeResult] | None = None
        self._tick: Tick | None = None
        self._passed: list[Transition] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[States, dict[str, Any]]:
        """Begin an episode; equal seeds give equal ones.

        Args:
            seed: Seed of this episode and the following ones.
            options: No options are known.

        Raises:
            gymnasium.error.ClosedEnvironmentError: The environment is closed.
        """
        self._require_open()
        super().reset(seed=seed)
        self._leave()
        # A reset without a seed goes on with the generator of the last seed. Successive episodes
        # thus differ, and their sequence can be repeated.
        drawn = int(self.np_random.integers(_SEEDS))
        self._passed = []
        self._ticks = self._robot.ticks(
            drawn, policy=self._policy, context=self._context, on_transition=self._note
        )
        self._advance()
        return self._observed(), self._info()

    def step(self, action: np.int64) -> tuple[States, float, bool, bool, dict[str, Any]]:
        """Run an action until the state changes, or its time is over.

        Raises:
            gymnasium.error.ResetNeeded: No episode runs.
            gymnasium.error.InvalidAction: There is no action of this number.
            gymnasium.error.ClosedEnvironmentError: The environment is closed.
        """
        self._require_open()
        if self._ticks is None or self._tick is None:
            raise gymnasium.error.ResetNeeded("reset begins an episode")
        if not self.action_space.contains(action):
            known = f"0 to {len(self.actions) - 1}"
            raise gymnasium.error.InvalidAction(f"{action!r} is not an action; known: {known}")
        before, run = len(self._passed), self._tick.run
        run.decide(self.actions[int(action)])
        self._advance()
        reward = sum(transition.reward for transition in self._passed[before:])
        if run.outcome == "success":
            reward = max(reward, 1)
        # The predicate 0 means that the program is on its way. An end without reward and outcome is
        # one of time or of transitions, and truncates the episode.
        ended = run.predicate != "0"
        terminated = ended and (run.rewarded or bool(run.outcome))
        return self._observed(), float(reward), terminated, ended and not terminated, self._info()

    def close(self) -> None:
        """End the episode and close the robot; no episode can run afterwards."""
        self._is_open = False
        self._leave()
        self._open.close()

    def _require_open(self) -> None:
        if not self._is_open:
            raise gymnasium.error.ClosedEnvironmentError("this environment is closed; make another")

    def _advance(self) -> None:
        """Run until the agent has to choose, or the episode is over."""
        assert self._ticks is not None, "an episode runs"
        for tick in self._ticks:
            self._tick = tick
            # The state has changed, and the deferred policy leaves the next action to the agent.
            if tick.run.is_open:
                return
        self._ticks = None

    def _note(self, transition: Transition) -> None:
        # Transitions of used programs are within one action of this program.
        if transition.depth == 0:
            self._passed.append(transition)

    def _observed(self) -> States:
        assert self._tick is not None, "an episode was begun"
        return np.array([LETTERS.index(letter) for letter in self._tick.run.state], dtype=np.int64)

    def _info(self) -> dict[str, Any]:
        assert self._tick is not None, "an episode was begun"
        run = self._tick.run
        return {"state": run.state, "time": self._tick.observation.time, "ending": run.ending}

    def _leave(self) -> None:
        if self._ticks is not None:
            self._ticks.close()
            self._ticks = None
