"""Policies in their own documents: whether they fit, and programs that run under them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.checking.knowledge.impossible_states import check_possible
from cbdsl.checking.knowledge.model import examine_model
from cbdsl.checking.knowledge.states import check_states
from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.language.parser import parse
from cbdsl.language.scanner import CompositionError
from cbdsl.program.binding import bind, density_source, internal_models
from cbdsl.program.checked import CheckedProgram
from cbdsl.types.resource_type import POSITION
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

if TYPE_CHECKING:
    from cbdsl.documents.schema import SchemaDocument


def with_policy(
    program: CheckedProgram, loaded: Loaded[PolicyDocument], library: Library
) -> CheckedProgram:
    """Return a program under another policy, which draws from that policy's internal models.

    Args:
        program: Program that the policy serves.
        loaded: Policy without diagnostics.
        library: Library that finds its models by name.
    """
    return with_models(
        program._replace(policy=loaded.document.policy, is_learned=True), loaded, library
    )


def with_models(
    program: CheckedProgram,
    loaded: Loaded[PolicyDocument] | Loaded[SchemaDocument],
    library: Library,
) -> CheckedProgram:
    """Return a program that draws from the internal models of its robot that knowledge names.

    Args:
        program: Program with other models.
        loaded: Knowledge without diagnostics.
        library: Library that finds its models by name.
    """
    sources = {}
    for name, model in loaded.document.models.items():
        path = library.find(ModelDocument, model, loaded.path)
        assert path is not None, "knowledge without findings names models that are there"
        document = library.read(path, ModelDocument).document
        if document.robot == program.robot:
            sources[name] = density_source(document.effector, document.density)
    return bind(program, sources)


def check_models(
    loaded: Loaded[PolicyDocument] | Loaded[SchemaDocument],
    program: CheckedProgram,
    session: Session,
    diagnostics: Diagnostics,
) -> None:
    """Check that the internal models that knowledge names are those of its program."""
    source, known = loaded.source, internal_models(program)
    for name, model in loaded.document.models.items():
        if name not in known:
            details = {"program": program.name, "name": name}
            diagnostics.add("CB623", source.key("models", name), names=list(known), **details)
            continue
        place = source.place("models", name)
        path = find_document(
            ModelDocument, model, place, session.library, diagnostics, program.robot
        )
        read = session.read(path, ModelDocument, diagnostics)
        if isinstance(read, Unknown):
            continue
        examine_model(read, session, diagnostics)
        document, effector = read.document, name.partition(".")[0]
        is_place, draws_place = document.space == "position", known[name].type == POSITION
        if document.effector != effector or is_place != draws_place:
            other = f"{document.effector}.position" if is_place else document.effector
            effector = f"{effector}.position" if draws_place else effector
            details = {"model": model, "other": other, "name": name}
            diagnostics.add("CB624", place, effector=effector, **details)


def check_policy(
    loaded: Loaded[PolicyDocument],
    program: CheckedProgram,
    program_file: Path,
    session: Session,
    diagnostics: Diagnostics,
) -> None:
    """Check a policy against the program that it serves, and collect ``diagnostics``."""
    _PolicyCheck(loaded, program, session, diagnostics).check(program_file)


class _PolicyCheck:
    def __init__(
        self,
        loaded: Loaded[PolicyDocument],
        program: CheckedProgram,
        session: Session,
        diagnostics: Diagnostics,
    ) -> None:
        self._loaded, self._document, self._source = loaded, loaded.document, loaded.source
        self._program, self._session, self._diagnostics = program, session, diagnostics
        self._actions = [action.name for action in program.actions]
        predicates = self._source.known(self._document.predicates, "predicates")
        self._members = program.members if isinstance(predicates, Unknown) else predicates

    def check(self, program_file: Path) -> None:
        self._unchanged(program_file)
        self._predicates()
        for pattern, text in self._document.policy.items():
            self._action(text, ("policy", pattern))
        check_states(self._document.policy, self._members, self._source, self._diagnostics)
        # The letters of a state stand for the members in order. With other members, or with invalid
        # patterns, each letter may be assigned to a wrong controller.
        if self._members == self._program.members and not self._diagnostics.holds(
            ("CB611", "CB612")
        ):
            policy = self._document.policy
            check_possible(policy, self._program, self._source, self._diagnostics)
        self._observed()
        # A policy over roles serves other robots, which have internal models of their own.
        if self._home == self._program.robot:
            check_models(self._loaded, self._program, self._session, self._diagnostics)

    @property
    def _home(self) -> str:
        """Robot that learned the policy; that of the program if it was written."""
        provenance = self._document.provenance
        return self._program.robot if provenance is None else provenance.robot.name

    def _unchanged(self, program_file: Path) -> None:
        """Check that the program is the one for which the policy was learned."""
        # Only learned policies need it.
        from cbdsl.checking.knowledge.program_digest import program_digest

        provenance, library = self._document.provenance, self._session.library
        if provenance is None:
            return
        roles = library.read_as_written(program_file, ProgramDocument).document.roles
        if roles and library.find(RobotDocument, self._home, program_file) is None:
            return  # the program on the robot of the learning is unknown
        now = program_digest(program_file, library, self._home).sha256
        learned = provenance.program
        if (learned.name, learned.sha256) != (self._program.name, now):
            place = self._source.place("provenance", "program", "sha256")
            details = {"program": self._program.name, "command": provenance.command}
            self._diagnostics.add("CB622", place, **details)

    def _predicates(self) -> None:
        members, program = self._members, self._program
        if members != program.members:
            given, wanted = ", ".join(members), ", ".join(program.members)
            details = {"found": given, "wanted": wanted, "program": program.name}
            self._diagnostics.add("CB621", self._source.key("predicates"), **details)

    def _action(self, text: str, steps: tuple[Step, ...]) -> None:
        try:
            action = str(parse(text))
        except CompositionError as error:
            place = self._source.inside(steps, error.span.start, error.span.end)
            self._diagnostics.add("CB401", place, problem=str(error))
            return
        if action not in self._actions:
            place = self._source.place(*steps)
            self._diagnostics.add("CB613", place, names=self._actions, name=action)

    def _observed(self) -> None:
        """Check the states and actions in the recorded values and transitions."""
        for key, by_state in (
            ("values", self._document.values),
            ("transitions", self._document.transitions),
        ):
            for state, by_action in by_state.items():
                self._state(state, (key, state))
                for action in by_action:
                    if action not in self._actions:
                        place = self._source.key(key, state, action)
                        self._diagnostics.add("CB613", place, names=self._actions, name=action)
        for state, counts in self._document.transitions.items():
            for action, after in counts.items():
                for reached in after:
                    self._state(reached, ("transitions", state, action, reached))

    def _state(self, state: str, steps: tuple[Step, ...]) -> None:
        members = self._members
        if len(state) != len(members):
            given, wanted = count(len(state), "letter"), count(len(members), "predicate")
            place, names = self._source.key(*steps), ", ".join(members)
            self._diagnostics.add("CB611", place, found=given, wanted=wanted, members=names)
