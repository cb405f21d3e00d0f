"""Request to learn: one object for ``cb learn`` and ``cbdsl.learn``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.document import Section
    from cbdsl.documents.document_digest import ProgramDigest
    from cbdsl.documents.relations import RelationsDocument
    from cbdsl.program.checked import CheckedProgram
    from cbdsl.training.learning_task import LearningTask


@dataclass(frozen=True)
class LearnRequest:
    """Trials of a program, each from scratch, with all their inputs.

    Attributes:
        run: Program with its robot and its training stage.
        out: File for the policy, ``NAME.yaml``; several trials write ``NAME_0.yaml`` and so on.
        episodes: Total number of episodes of each trial.
        seed: Seed of all random draws.
        trials: Number of trials.
        backend: Name of the backend; the first installed one if ``None``.
        cameras: Kind of the backend's cameras; the backend's default if ``None``.
        learner: Name of the algorithm.
        constants: Constants of the algorithm by name, as text with units or in SI.
        policy: Policy whose resources ``assimilate`` learns, or relations from which
            ``name_relations`` goes on: file or name.
        sequential: True to leave out actions that are compositions.
        transitions: Maximum number of transitions of an episode; the program's if ``None``.
        transition_time: Maximum time of an action without a change of state, s; the program's if
            ``None``.
        idle_time: Maximum time without a predicate of 0, s; the program's if ``None``.
        episode_time: Maximum time of an episode, s; the program's if ``None``.
        command: Command that repeats the learning, for the provenance of the documents.
    """

    run: RunRequest
    out: Path
    episodes: int = 10
    seed: int = 0
    trials: int = 1
    backend: str | None = None
    cameras: str | None = None
    learner: str = "accommodate"
    constants: Mapping[str, str | float] = field(default_factory=dict)
    policy: str | None = None
    sequential: bool = False
    transitions: int | None = None
    transition_time: float | None = None
    idle_time: float | None = None
    episode_time: float | None = None
    command: str = ""

    def checked_constants(self) -> Section:
        """Return the constants with the defaults of the algorithm.

        Raises:
            UsageError: The learner or a constant is unknown, or a value is not allowed.
        """
        from cbdsl.learning.constants import read_constants
        from cbdsl.learning.learner import LEARNERS

        return read_constants(LEARNERS.get(self.learner).Constants, self.constants, self.learner)

    def tasks(self) -> list[LearningTask]:
        """Return one task for each trial, ready to run in any process.

        Raises:
            DiagnosticsError: The policy has errors.
            UsageError: An item is unknown or unsuitable.
        """
        from cbdsl.backends.engines import default_engine
        from cbdsl.storage.atomic_file import require_unlinked
        from cbdsl.training.learning_task import LearningTask

        self.require_sound()
        program, digest = self._program()
        first = LearningTask(
            program=self._limited(program),
            digest=digest,
            robot=self.run.robot,
            # Absolute paths remain valid in workers, whose working folders may differ.
            urdf=self.run.urdf.absolute(),
            stage=self.run.stage,
            backend=default_engine() if self.backend is None else self.backend,
            learner=self.learner,
            constants=self.checked_constants(),
            seed=self.seed,
            number=0,
            episodes=self.episodes,
            command=self.command or self._call(),
            path=self.out.absolute(),
            cameras=self.cameras,
            earlier=self._earlier(),
        )
        if self.trials == 1:
            return [first]
        # All trials have the seed of the request; their numbers distinguish their random draws.
        paths = [first.path.with_stem(f"{first.path.stem}_{n}") for n in range(self.trials)]
        for path in paths:
            require_unlinked(path)
        return [replace(first, number=n, path=path) for n, path in enumerate(paths)]

    def require_sound(self) -> None:
        """Check that the file can hold a policy, and that learner and policy fit each other.

        Raises:
            UsageError: One of them does not.
        """
        from cbdsl.diagnostics.errors import UsageError
        from cbdsl.documents.document import NAME_PATTERN
        from cbdsl.learning.learner import ASSIMILATE, NAME_RELATIONS

        if self.out.suffix != ".yaml" or not re.fullmatch(NAME_PATTERN, self.out.stem):
            raise UsageError(f"{self.out}: a policy is <name>.yaml, of letters, digits and _")
        if self.out.is_dir():
            raise UsageError(f"{self.out}: is a folder, and a policy is a file")
        if self.learner == ASSIMILATE and self.policy is None:
            raise UsageError("assimilate learns the resources of a policy, and none is named")
        if self.learner not in (ASSIMILATE, NAME_RELATIONS) and self.policy is not None:
            raise UsageError(
                f"'{self.learner}' learns a policy from scratch; only {ASSIMILATE} and "
                f"{NAME_RELATIONS} start from '{self.policy}'"
            )
        if self.learner == NAME_RELATIONS:
            self._require_relations()

    def _require_relations(self) -> None:
        """Check that the program tests impedance, and that the stage names relations."""
        from cbdsl.diagnostics.errors import UsageError
        from cbdsl.training.impedance_gauge import ImpedanceGauge

        program, stage = self.run.program, self.run.stage
        if not ImpedanceGauge(program).listens:
            raise UsageError(
                f"'{program.name}' tests no impedance: it uses no program that tracks a net load "
                "along one axis, such as 'push' or 'twist'"
            )
        if not any(context.relation for context in stage.contexts.values()):
            raise UsageError(
                f"stage '{stage.name}' names no relation: give its contexts 'relation', such as "
                "'relation: spherical'"
            )

    def _earlier(self) -> RelationsDocument | None:
        """Return the relations from which the learner goes on.

        Raises:
            DiagnosticsError: They have errors.
            UsageError: There is no such document, or it is about another program.
        """
        from cbdsl.learning.learner import NAME_RELATIONS

        if self.learner != NAME_RELATIONS or self.policy is None:
            return None
        from cbdsl.api.reading.relations import read_relations
        from cbdsl.diagnostics.errors import UsageError

        earlier = read_relations(self.policy, self.run.library).document
        if earlier.program != self.run.program.name:
            raise UsageError(
                f"{self.policy}: its tests are those of '{earlier.program}', not of "
                f"'{self.run.program.name}'"
            )
        return earlier

    def _program(self) -> tuple[CheckedProgram, ProgramDigest]:
        """Return the program to learn, with all its allocations for a policy, and its digest."""
        from cbdsl.api.requests.run_request import read_policy
        from cbdsl.checking.assimilation import program_to_assimilate
        from cbdsl.checking.knowledge.program_digest import (
            policy_digest,
            program_digest,
            substitute_digests,
        )
        from cbdsl.checking.session import Session
        from cbdsl.learning.learner import ASSIMILATE

        run = self.run
        digest = program_digest(run.program_file, run.library)
        if self.policy is None or self.learner != ASSIMILATE:
            return run.program, digest
        loaded = read_policy(run.program, self.policy, run.program_file, run.library)
        session = Session(run.library)
        program = program_to_assimilate(run.program_file, loaded, session, run.values)
        # A schema depends on the policy whose resources it chooses, and on programs that replace
        # others. It becomes stale if one of them changes.
        own = policy_digest(loaded.document.name, run.program_file, run.library)
        policies = {loaded.document.name: own, **digest.policies}
        allocations = program.schema.allocations if program.schema is not None else {}
        programs = substitute_digests(allocations, run.program_file, run.library)
        return program, digest._replace(policies=policies, programs=programs)

    def _limited(self, program: CheckedProgram) -> CheckedProgram:
        """Return the program with the actions and limits of the trials."""
        # The options of the command exclude 0, so that `or` replaces only a missing limit.
        return program._replace(
            actions=program.sequential_actions if self.sequential else program.actions,
            transitions=self.transitions or program.transitions,
            transition_time=self.transition_time or program.transition_time,
            idle_time=self.idle_time or program.idle_time,
            episode_time=self.episode_time or program.episode_time,
        )

    def _call(self) -> str:
        """Return the call in Python that repeats the learning."""
        from cbdsl.api.requests.call_text import call_text, chosen, load_text

        loaded = load_text(self.run, self.run.program.parameters)
        always = ("episodes", "seed", "backend", "learner")
        names = ("trials", "policy", "sequential", "transitions", "transition_time", "idle_time",
                 "episode_time", "cameras")  # fmt: skip
        options = chosen(self, always, always) | {"constants": dict(self.constants)}
        return call_text("learn", [loaded, f"{self.out.name!r}"], options | chosen(self, names))
