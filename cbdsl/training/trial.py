"""One trial: episodes from which one learner learns (Algorithm 1)."""

from __future__ import annotations

import numpy as np

from cbdsl.documents.document import Section
from cbdsl.learning.experience import Experience
from cbdsl.learning.learner import ACCOMMODATE, LEARNERS, SchemaLearner, replay
from cbdsl.program.binding import bind, density_source, internal_models
from cbdsl.program.checked import CheckedProgram
from cbdsl.training.episode_runner import EpisodeRunner
from cbdsl.types.resource import UniformSample

# What an episode's seed is used for besides the world (0) and the program's draws (1).
_EXPLORATION = 2


class Trial:
    """Learner and its episodes so far, from zero.

    Its knowledge follows from its experiences alone: another trial that replays them in the same
    order is the same trial.

    Attributes:
        program: what is learned; its actions are what can be chosen.
        constants: of the algorithm.
        seed: of all chance.
        number: which of several trials with this seed.
        algorithm: name of the learner.
        learner: what was learned so far.
        experiences: the episodes so far.
    """

    def __init__(
        self,
        program: CheckedProgram,
        constants: Section,
        seed: int,
        number: int = 0,
        algorithm: str = ACCOMMODATE,
    ) -> None:
        self.program, self.constants = program, constants
        self.seed, self.number = seed, number
        self.algorithm = algorithm
        actions = [action.name for action in program.actions]
        self.learner = LEARNERS.get(algorithm)(actions, constants, used_programs(program))
        if isinstance(self.learner, SchemaLearner):
            self.learner.adopt(program)
        self.experiences: list[Experience] = []

    def replay(self, experience: Experience) -> None:
        """Take in the next episode, which was run before."""
        replay(self.learner, experience)
        self.experiences.append(experience)

    def run(self, runner: EpisodeRunner) -> Experience:
        """Run the next episode and learn from it."""
        seed = self._next_seed()
        policy = self.learner.policy(np.random.default_rng([seed, _EXPLORATION]))
        program = self.informed_program()
        experience = runner.run(program, policy, seed, self.learner.see)
        self.learner.remember(experience)
        self.experiences.append(experience)
        return experience

    def learned_models(self) -> dict[str, str]:
        """Effectors of the internal models that start uniform, by name of the model.

        Only those of effectors that were rewarded so far; models that the program names itself
        are known already, and stay as they are.
        """
        known = self.learner.densities()
        return {
            name: resource.source.effector
            for name, resource in internal_models(self.program).items()
            if isinstance(resource.source, UniformSample) and resource.source.effector in known
        }

    def informed_program(self) -> CheckedProgram:
        """Program that draws from the internal models learned so far."""
        densities = self.learner.densities()
        sources = {
            name: density_source(effector, densities[effector])
            for name, effector in self.learned_models().items()
        }
        return bind(self.program, sources)

    def _next_seed(self) -> int:
        """Seed of the next episode, with which ``cb run`` meets the same world."""
        entropy = np.random.SeedSequence([self.seed, self.number, len(self.experiences)])
        return int(entropy.generate_state(1)[0])


def used_programs(program: CheckedProgram) -> dict[int, str]:
    """Actions that are programs, by the place of their predicates in a state."""
    return {
        program.members.index(action.part): action.part
        for action in program.actions
        if action.program is not None
    }
