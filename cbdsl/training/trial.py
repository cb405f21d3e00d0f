"""Trial: episodes from which one learner learns (Algorithm 1)."""

from __future__ import annotations

import numpy as np

from cbdsl.documents.document import Section
from cbdsl.documents.relations import RelationsDocument
from cbdsl.learning.experience import Experience
from cbdsl.learning.learner import ACCOMMODATE, LEARNERS, ContinuingLearner, SchemaLearner, replay
from cbdsl.program.binding import bind, density_source, internal_models
from cbdsl.program.checked import CheckedProgram
from cbdsl.training.episode_runner import EpisodeRunner
from cbdsl.types.source_record import owner_of, record_of

# Stream of an episode's seed for exploration, beside the world (0) and the program's draws (1).
_EXPLORATION = 2


class Trial:
    """Learner with its episodes so far, from zero.

    Its knowledge depends on its experiences alone: another trial that replays them in the same
    order has the same knowledge.

    Attributes:
        program: Program to learn; its actions are the choices.
        constants: Constants of the algorithm.
        seed: Seed of all random numbers.
        number: Number of this trial among several with this seed.
        algorithm: Name of the learner.
        earlier: Knowledge from which the learner goes on, if any.
        learner: Learner with its present knowledge.
        experiences: Experiences of the episodes so far.
    """

    def __init__(
        self,
        program: CheckedProgram,
        constants: Section,
        seed: int,
        number: int = 0,
        algorithm: str = ACCOMMODATE,
        earlier: RelationsDocument | None = None,
    ) -> None:
        self.program, self.constants = program, constants
        self.seed, self.number = seed, number
        self.algorithm = algorithm
        actions = [action.name for action in program.actions]
        self.learner = LEARNERS.get(algorithm)(actions, constants, used_programs(program))
        if isinstance(self.learner, SchemaLearner):
            self.learner.adopt(program)
        self.earlier = earlier
        if earlier is not None and isinstance(self.learner, ContinuingLearner):
            self.learner.recall(earlier)
        self.experiences: list[Experience] = []

    def replay(self, experience: Experience) -> None:
        """Learn from the next episode, which was run earlier."""
        replay(self.learner, experience)
        self.experiences.append(experience)

    def run(self, runner: EpisodeRunner) -> Experience:
        """Run the next episode and learn from it."""
        experience = self.play(runner)
        self.remember(experience)
        return experience

    def play(self, runner: EpisodeRunner) -> Experience:
        """Run the next episode, during which the learner sees its transitions."""
        seed = self._next_seed()
        policy = self.learner.policy(np.random.default_rng([seed, _EXPLORATION]))
        return runner.run(self.informed_program(), policy, seed, self.learner.see)

    def remember(self, experience: Experience) -> None:
        """Learn from an episode that was just run."""
        self.learner.remember(experience)
        self.experiences.append(experience)

    def learned_models(self) -> dict[str, str]:
        """Return the effectors of the internal models that start uniform, by name of the model.

        The result has only effectors that were rewarded so far. Models that the program names
        itself are known already, and stay unchanged.
        """
        known = self.learner.densities()
        return {
            name: owner_of(resource.source)
            for name, resource in internal_models(self.program).items()
            if record_of(resource.source).uniform and owner_of(resource.source) in known
        }

    def informed_program(self) -> CheckedProgram:
        """Return the program with samples from the internal models learned so far."""
        densities = self.learner.densities()
        sources = {
            name: density_source(effector, densities[effector])
            for name, effector in self.learned_models().items()
        }
        return bind(self.program, sources)

    def _next_seed(self) -> int:
        """Return the seed of the next episode; ``cb run`` with this seed meets the same world."""
        # The place of the episode in its trial determines the seed, so a resumed trial goes on with
        # the same seeds.
        entropy = np.random.SeedSequence([self.seed, self.number, len(self.experiences)])
        return int(entropy.generate_state(1)[0])


def used_programs(program: CheckedProgram) -> dict[int, str]:
    """Return the actions that are programs, by the index of their predicates in a state."""
    return {
        program.members.index(action.part): action.part
        for action in program.actions
        if action.program is not None
    }
