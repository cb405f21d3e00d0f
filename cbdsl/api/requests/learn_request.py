"""Request to learn: one object for ``cb learn`` and ``cbdsl.learn``."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.api.requests.declaration import (
    BACKEND,
    CAMERAS,
    COMMAND,
    CONSTANTS,
    SEED,
    call_text,
    declaration,
    engine_of,
    given,
    load_text,
)

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.document import Section
    from cbdsl.documents.document_digest import ProgramDigest
    from cbdsl.documents.policy import Identity, PolicyDocument
    from cbdsl.documents.relations import RelationsDocument
    from cbdsl.documents.schema import SchemaDocument
    from cbdsl.learning.experience import Experience
    from cbdsl.program.checked import CheckedProgram
    from cbdsl.training.learning_task import LearningTask


_TRIAL, _ALGORITHM, _LIMITS = "Trial options", "Algorithm options", "Limit options"


@declaration
class LearnRequest:
    """Trials of a program, each from scratch, with all their inputs."""

    program: str | Path | RunRequest = given(
        "Result of ``load``, or a file or name for it.", kw_only=False
    )
    out: str | Path = given(
        "File for the policy, ``NAME.yaml``; internal models are written beside it.",
        kw_only=False,
        kind=Path,
    )
    episodes: int = given(
        "Total number of episodes.", default=10, always=True, kind=int, group=_TRIAL, min=1
    )
    seed: int = given(SEED, default=0, always=True, group=_TRIAL)
    backend: str | None = given(BACKEND, default=None, always=True, group=_TRIAL)
    cameras: str | None = given(CAMERAS, default=None, group=_TRIAL)
    trials: int = given(
        "Number of trials, each from scratch: ``NAME_0.yaml``, ``NAME_1.yaml``, ...",
        default=1,
        kind=int,
        group=_TRIAL,
        min=1,
        max=10_000,
    )
    resume: bool = given(
        "True to continue trials that were begun there.",
        default=False,
        recorded=False,
        group="Process options",
    )
    sequential: bool = given(
        "True to leave out actions that are compositions.",
        default=False,
        kind=bool,
        help="Leave out actions that are compositions.",
        group=_ALGORITHM,
    )
    learner: str | None = given(
        "Name of the algorithm [``transfer`` with a policy, else ``accommodate``].",
        default=None,
        kind=str | None,
        help="Learner; cb show learners lists all [with --from transfer, else accommodate].",
        group=_ALGORITHM,
    )
    policy: str | Path | None = given(
        "File or name of the policy whose resources ``assimilate`` learns, of the policy or schema"
        " of another robot for ``transfer``, or of the relations from which ``name_relations`` goes"
        " on.",
        default=None,
        kind=str | None,
        help="Policy or schema of another robot to keep the policy of; with assimilate: learned "
        "policy of the schema; with name_relations: relations to go on from. File or name.",
        flag="--from",
        group=_ALGORITHM,
    )
    constants: Mapping[str, str | float] = given(CONSTANTS, default_factory=dict, group=_ALGORITHM)
    transitions: int | None = given(
        "Maximum number of transitions of an episode [the program's].",
        default=None,
        kind=int | None,
        group=_LIMITS,
        min=1,
    )
    transition_time: float | None = given(
        "Maximum time of one action without a change of state, s [the program's].",
        default=None,
        kind=float | None,
        group=_LIMITS,
        min=0.1,
        max=86400,
    )
    idle_time: float | None = given(
        "The same while no predicate is 0, s [the program's].",
        default=None,
        kind=float | None,
        group=_LIMITS,
        min=0.1,
        max=86400,
    )
    episode_time: float | None = given(
        "Maximum time of an episode, s, including the programs that it uses [the program's].",
        default=None,
        kind=float | None,
        group=_LIMITS,
        min=0.1,
        max=86400,
    )
    command: str = given(COMMAND, default="", recorded=False)
    on_episode: Callable[[Experience], None] | None = given(
        "Function called with each new episode that runs in this process.",
        default=None,
        recorded=False,
    )

    @cached_property
    def run(self) -> RunRequest:
        """Program with its robot and its training stage, read and checked."""
        from cbdsl.api.requests.load_request import LoadOptions
        from cbdsl.api.requests.run_request import RunRequest

        if isinstance(self.program, RunRequest):
            return self.program
        return LoadOptions().read(self.program)

    @property
    def algorithm(self) -> str:
        """Name of the learner, given or by default."""
        from cbdsl.learning.learner import ACCOMMODATE, TRANSFER

        return self.learner or (ACCOMMODATE if self.policy is None else TRANSFER)

    @property
    def path(self) -> Path:
        """File for the policy."""
        return Path(self.out)

    def checked_constants(self) -> Section:
        """Return the constants with the defaults of the algorithm.

        Raises:
            UsageError: The learner or a constant is unknown, or a value is not allowed.
        """
        from cbdsl.learning.constants import read_constants
        from cbdsl.learning.learner import LEARNERS

        return read_constants(
            LEARNERS.get(self.algorithm).Constants, self.constants, self.algorithm
        )

    def tasks(self) -> list[LearningTask]:
        """Return one task for each trial, ready to run in any process.

        Raises:
            DiagnosticsError: The policy has errors.
            UsageError: An item is unknown or unsuitable.
        """
        from cbdsl.storage.atomic_file import require_unlinked
        from cbdsl.training.learning_task import LearningTask

        self.require_sound()
        program, digest, origin = self._program()
        first = LearningTask(
            program=self._limited(program),
            digest=digest,
            robot=self.run.robot,
            # Absolute paths remain valid in workers, whose working folders may differ.
            urdf=self.run.urdf.absolute(),
            stage=self.run.stage,
            backend=engine_of(self),
            learner=self.algorithm,
            constants=self.checked_constants(),
            seed=self.seed,
            number=0,
            episodes=self.episodes,
            command=self.command or self._call(),
            path=self.path.absolute(),
            cameras=self.cameras,
            earlier=self._earlier(),
            origin=origin,
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
        from cbdsl.learning.learner import ASSIMILATE, NAME_RELATIONS, TRANSFER

        learner = self.algorithm
        if self.path.suffix != ".yaml" or not re.fullmatch(NAME_PATTERN, self.path.stem):
            raise UsageError(f"{self.path}: a policy is <name>.yaml, of letters, digits and _")
        if self.path.is_dir():
            raise UsageError(f"{self.path}: is a folder, and a policy is a file")
        if learner in (ASSIMILATE, TRANSFER) and self.policy is None:
            raise UsageError(f"{learner} learns the resources of a policy, and none is named")
        if learner not in (ASSIMILATE, TRANSFER, NAME_RELATIONS) and self.policy is not None:
            raise UsageError(
                f"'{learner}' learns a policy from scratch; only {ASSIMILATE}, {TRANSFER} and "
                f"{NAME_RELATIONS} start from '{self.policy}'"
            )
        if learner == NAME_RELATIONS:
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

        if self.algorithm != NAME_RELATIONS or self.policy is None:
            return None
        from cbdsl.api.reading.relations import read_relations
        from cbdsl.diagnostics.errors import UsageError

        earlier = read_relations(str(self.policy), self.run.library).document
        if earlier.program != self.run.program.name:
            raise UsageError(
                f"{self.policy}: its tests are those of '{earlier.program}', not of "
                f"'{self.run.program.name}'"
            )
        return earlier

    def _program(self) -> tuple[CheckedProgram, ProgramDigest, Identity | None]:
        """Return the program to learn, with all its allocations for a policy.

        Returns:
            Program, its digest, and the other robot that learned the policy, if there is one.
        """
        from cbdsl.api.requests.run_request import find_schema, read_policy
        from cbdsl.checking.assimilation import program_to_assimilate
        from cbdsl.checking.knowledge.program_digest import policy_digest, substitute_digests
        from cbdsl.checking.session import Session
        from cbdsl.learning.learner import ASSIMILATE, TRANSFER

        run, is_transfer = self.run, self.algorithm == TRANSFER
        digest, named = run.digest, str(self.policy)
        if self.policy is None or self.algorithm not in (ASSIMILATE, TRANSFER):
            return run.program, digest, None
        beside, origin = run.program_file, None
        if is_transfer and (schema := find_schema(run.program, named, beside, run.library)):
            self._origin(schema.document)
            named, beside = schema.document.policy, schema.path
        loaded = read_policy(run.program, named, beside, run.library)
        self._require_found(loaded.document.name)
        if is_transfer:
            origin = self._origin(loaded.document)
        session = Session(run.library)
        least = 1 if is_transfer else 2
        program = program_to_assimilate(run.program_file, loaded, session, run.values, least)
        # A schema depends on the policy whose resources it chooses, and on programs that replace
        # others. It becomes stale if one of them changes.
        own = policy_digest(loaded.document.name, self.path, run.library)
        policies = {loaded.document.name: own, **digest.policies}
        allocations = program.schema.allocations if program.schema is not None else {}
        programs = substitute_digests(allocations, run.program_file, run.library)
        return program, digest._replace(policies=policies, programs=programs), origin

    def _require_found(self, policy: str) -> None:
        """Check that the schema to be written will find its policy by name.

        Raises:
            UsageError: It will not.
        """
        from cbdsl.diagnostics.errors import UsageError
        from cbdsl.documents.policy import PolicyDocument

        if self.run.library.find(PolicyDocument, policy, self.path) is None:
            raise UsageError(
                f"{self.path}: a schema there does not find its policy '{policy}'; copy that "
                "beside it or to knowledge/policies, or write the schema where the policy is"
            )

    def _origin(self, knowledge: PolicyDocument | SchemaDocument) -> Identity | None:
        """Return the robot that learned a policy or a schema; ``None`` for a written one.

        Raises:
            UsageError: The program runs on that robot.
        """
        from cbdsl.diagnostics.errors import UsageError

        origin = None if knowledge.provenance is None else knowledge.provenance.robot
        if origin is not None and origin.name == self.run.robot.name:
            raise UsageError(
                f"{self.policy}: robot '{origin.name}' has learned this itself; name another "
                "one by --robot, or learn the resources of its policy by --learner assimilate"
            )
        return origin

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
        loaded = load_text(self.run, self.run.program.parameters)
        return call_text("cbdsl.learn", self, program=loaded, out=repr(self.path.name))
