"""Schemas: whether they fit their programs, and programs that run as schemas."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from cbdsl.checking.allotments import exchangeable
from cbdsl.checking.knowledge.policy_agreement import (
    check_models,
    check_policy,
    with_models,
    with_policy,
)
from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.lookup.scope import Scope
from cbdsl.checking.open_members import MemberExchange
from cbdsl.checking.prior_looks import look_of
from cbdsl.checking.question_tree import QuestionTrees
from cbdsl.checking.session import Session
from cbdsl.checking.substitution import Examine, stand_in
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.catalog import CatalogDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.schema import SchemaDocument
from cbdsl.program.allocated_program import allocate
from cbdsl.program.checked import CheckedProgram, PriorLook
from cbdsl.program.controller import Controller
from cbdsl.program.schema import Ranking, Schema, components
from cbdsl.program.state_values import state_values
from cbdsl.types.allotment import WHOLE
from cbdsl.types.decision_tree import Tree
from cbdsl.types.resource import AFFORDS, Resource
from cbdsl.types.resource_type import COUNT
from cbdsl.types.role import ROBOT
from cbdsl.types.source_record import is_visual
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

Steps = tuple[Step, ...]


def checked_schema(
    loaded: Loaded[SchemaDocument],
    session: Session,
    diagnostics: Diagnostics,
    examine: Examine,
    values: Mapping[str, str] | None = None,
) -> Outcome[CheckedProgram]:
    """Return the program of a schema with all its allocations; unknown if it does not fit.

    Args:
        loaded: Schema's document.
        session: Session with the documents read so far.
        diagnostics: Diagnostics so far.
        examine: Check of a program with values of its parameters.
        values: Values of the program's other parameters that replace the defaults.
    """
    return _SchemaCheck(loaded, session, diagnostics, examine, values or {}).check()


class _SchemaCheck:
    def __init__(
        self,
        loaded: Loaded[SchemaDocument],
        session: Session,
        diagnostics: Diagnostics,
        examine: Examine,
        values: Mapping[str, str],
    ) -> None:
        self._loaded, self._document, self._source = loaded, loaded.document, loaded.source
        self._session, self._diagnostics = session, diagnostics
        self._examine, self._values = examine, dict(values)
        self._dimensions: dict[str, str] = {}
        #: Features that count objects, with the number that can be distinguished.
        self._counts: dict[str, int] = {}
        #: Features with a diagnostic, whose uses have none.
        self._reported: set[str] = set()

    def check(self) -> Outcome[CheckedProgram]:
        # Diagnostics of this schema are collected apart, since earlier ones must not make it fail.
        own = Diagnostics()
        outer, self._diagnostics = self._diagnostics, own
        program = self._check()
        outer.extend(own.sorted())
        return UNKNOWN if own.failed else program

    def _check(self) -> Outcome[CheckedProgram]:
        document, library = self._document, self._session.library
        path = library.find(ProgramDocument, document.program, self._loaded.path)
        policy = self._policy()
        if path is None or isinstance(policy, Unknown) or not self._is_at_home(path):
            return UNKNOWN
        variants = {
            name: variant
            for name, values in document.allocations.items()
            if not isinstance(variant := self._variant(name, values, path, policy), Unknown)
        }
        if len(variants) < len(document.allocations):
            return UNKNOWN
        self._unchanged()
        base = next(iter(variants.values()))
        self._actions(base)
        features = self._features(base)
        choice: Tree[Ranking] = self._trees.read(document.choose, ("choose",), self._ranking)
        reward = self._reward()
        self._names(document.otherwise, ("otherwise",))
        worth = state_values(policy.document.policy, policy.document.transitions)
        schema = Schema(
            policy=document.policy,
            features=features,
            allocations=document.allocations,
            choice=choice,
            otherwise=document.otherwise,
            reward=reward,
            tried=self._tried(),
            least_reward=document.least_reward,
            worth=worth,
        )
        program = allocate(variants, schema)._replace(looks=self._looks(base))
        check_models(self._loaded, program, self._session, self._diagnostics)
        return UNKNOWN if self._diagnostics.failed else with_models(program, self._loaded, library)

    def _is_at_home(self, program: Path) -> bool:
        """Check that a schema of a program over roles allocates the effectors of its robot."""
        provenance, library = self._document.provenance, self._session.library
        roles = library.read_as_written(program, ProgramDocument).document.roles
        if not roles:
            self._values.pop(ROBOT, None)
        if provenance is None or not roles:
            return True
        home = provenance.robot.name
        robot = self._values.setdefault(ROBOT, home)
        is_known = library.find(RobotDocument, home, program) is not None
        if robot != home or not is_known:
            details = {"name": self._document.name, "program": self._document.program}
            other = "which is not at hand" if robot == home else f"and not of '{robot}'"
            place = self._source.place("provenance", "robot", "name")
            self._diagnostics.add("CB646", place, robot=home, other=other, **details)
        return robot == home and is_known

    def _looks(self, program: CheckedProgram) -> dict[str, PriorLook]:
        """Return the programs that define features, by the feature's name."""
        looks, document = {}, self._document
        for name, use in document.look.items():
            if name not in document.features:
                place, names = self._source.key("look", name), list(document.features)
                self._diagnostics.add("CB638", place, names=names, name=name)
                continue
            values = {
                key: self._substituted(text, program, ("look", name, "with", key))
                for key, text in use.with_.items()
            }
            known = {key: v for key, v in values.items() if not isinstance(v, Unknown)}
            if len(known) < len(values):
                continue
            look = look_of(use, known, self._loaded.path, self._session, self._examine)
            if isinstance(look, str):
                place = self._source.key("look", name)
                self._diagnostics.add("CB645", place, name=name, program=use.program, problem=look)
            else:
                looks[name] = look
        return looks

    def _policy(self) -> Outcome[Loaded[PolicyDocument]]:
        place, library = self._source.place("policy"), self._session.library
        path = find_document(
            PolicyDocument, self._document.policy, place, library, self._diagnostics
        )
        return self._session.read(path, PolicyDocument, self._diagnostics)

    def _unchanged(self) -> None:
        """Check that the policies and substitutes with which a schema was learned are unchanged."""
        from cbdsl.checking.knowledge.staleness import changed_policies, changed_substitutes

        document, path, library = self._document, self._loaded.path, self._session.library
        provenance = document.provenance
        if provenance is None:
            return
        for name in changed_policies(provenance, path, library):
            place = self._source.place("provenance", "policies", name)
            self._diagnostics.add("CB644", place, name=name, command=provenance.command)
        for name in changed_substitutes(document, path, library):
            place = self._source.place("provenance", "programs", name)
            self._diagnostics.add("CB622", place, program=name, command=provenance.command)

    def _variant(
        self, name: str, values: Mapping[str, str], path: Path, policy: Loaded[PolicyDocument]
    ) -> Outcome[CheckedProgram]:
        """Return the program under one allocation and the declarative policy."""
        library = self._session.library
        document = library.read(path, ProgramDocument).document
        known, programs = document.assignable, exchangeable(document)
        for key in values:
            if key not in known and key not in programs:
                place = self._source.key("allocations", name, key)
                details = {"name": key, "program": self._document.program}
                names = [*known, *sorted(programs)]
                self._diagnostics.add("CB606", place, names=names, **details)
                return UNKNOWN
        program, problem = self._allocated({**self._values, **values}, path)
        if program is None:
            place = self._source.key("allocations", name)
            self._diagnostics.add("CB634", place, name=name, problem=problem)
            return UNKNOWN
        if policy.document.program != program.name:
            details = {"name": self._document.policy, "other": policy.document.program}
            place = self._source.place("policy")
            self._diagnostics.add("CB626", place, program=program.name, **details)
            return UNKNOWN
        check_policy(policy, program, path, self._session, self._diagnostics)
        return UNKNOWN if self._diagnostics.failed else with_policy(program, policy, library)

    def _allocated(
        self, values: Mapping[str, str], path: Path
    ) -> tuple[CheckedProgram | None, str]:
        """Return the program with some values, or its stand-in; else ``None`` and the reason."""
        known = {*self._session.library.read(path, ProgramDocument).document.assignable, ROBOT}
        own = {key: value for key, value in values.items() if key in known}
        members = {k: value for k, value in values.items() if k not in known and k != WHOLE}
        # An allocation either replaces the whole program, or some of its members.
        if WHOLE in values and members:
            return None, f"'{values[WHOLE]}' takes the place of all members already"
        if WHOLE in values:
            return stand_in(values[WHOLE], path, own, self._session, self._examine)
        faults = Diagnostics()
        program = self._examine(path, own, faults)
        if isinstance(program, Unknown) or faults.failed:
            fault = next((each for each in faults.sorted() if each.is_error), None)
            return None, fault.message if fault else "it has findings"
        exchange = MemberExchange(path, self._session, self._examine)
        for member, name in members.items():
            exchanged, refusal = exchange.exchanged(program, member, name)
            if exchanged is None:
                return None, refusal
            program = exchanged
        return program, ""

    def _actions(self, program: CheckedProgram) -> None:
        """Check that the abstract actions match the program's controllers."""
        own = {name: each.lead for name, each in program.primitives.items()}
        for name, action in self._document.actions.items():
            if name not in own:
                self._diagnostics.add(
                    "CB613", self._source.key("actions", name), names=list(own), name=name
                )
            elif (wanted := _abstract(own[name])) != (action.potential, action.in_, action.out):
                place, text = self._source.key("actions", name), "({}, {}, {})".format(*wanted)
                self._diagnostics.add("CB635", place, name=name, wanted=text)

    def _features(self, program: CheckedProgram) -> dict[str, Resource]:
        robot = self._session.library.find(RobotDocument, program.robot, self._loaded.path)
        body = self._session.body(robot or UNKNOWN, Diagnostics())
        resources = {} if isinstance(body, Unknown) else body.resources
        features = {}
        for name, text in self._document.features.items():
            wanted = self._substituted(text, program, ("features", name))
            if isinstance(wanted, Unknown):
                self._reported.add(name)
                continue
            if wanted.startswith(AFFORDS) and self._document.catalog is not None:
                self._dimensions[name] = ""
                made = self._affordance(name, wanted, resources)
                if not isinstance(made, Unknown):
                    features[name] = made
                continue
            if wanted not in resources:
                place = self._source.place("features", name)
                self._diagnostics.add("CB636", place, names=list(resources), name=wanted)
                self._reported.add(name)
                continue
            features[name] = resources[wanted]
            is_count = resources[wanted].type == COUNT and is_visual(resources[wanted].source)
            if is_count and not isinstance(body, Unknown):
                self._counts[name] = body.document.vision.regions.instances
            for component in components(name, resources[wanted]):
                self._dimensions[component] = resources[wanted].type.unit
        return features

    def _substituted(self, text: str, program: CheckedProgram, steps: Steps) -> Outcome[str]:
        """Return a text with the values of the program's parameters."""
        values = self._source.declared(program.parameters, "parameters")
        return Scope(values, {}).substitute(text, self._source, steps, self._diagnostics)

    def _affordance(
        self, name: str, wanted: str, resources: Mapping[str, Resource]
    ) -> Outcome[Resource]:
        """Return the probability of reward of a catalog's action, ``affords.<action>``."""
        assert self._document.catalog is not None
        place, library = self._source.place("catalog"), self._session.library
        path = find_document(
            CatalogDocument, self._document.catalog, place, library, self._diagnostics
        )
        loaded = self._session.read(path, CatalogDocument, self._diagnostics)
        if isinstance(loaded, Unknown):
            return UNKNOWN
        action, catalog = wanted.removeprefix(AFFORDS), loaded.document
        if action not in catalog.affordances:
            at, names = self._source.place("features", name), list(catalog.affordances)
            self._diagnostics.add("CB655", at, names=names, name=action, catalog=catalog.name)
            return UNKNOWN
        from cbdsl.program.catalog_models import affordance_resource  # imports numpy

        made = affordance_resource(catalog, action, resources)
        if made is None:
            at = self._source.place("features", name)
            self._diagnostics.add("CB656", at, name=action, catalog=catalog.name)
            return UNKNOWN
        return made

    @property
    def _trees(self) -> QuestionTrees:
        return QuestionTrees(
            self._source, self._diagnostics, self._dimensions, self._counts, self._reported
        )

    def _ranking(self, tree: object, steps: Steps) -> Ranking:
        ranking = (tree,) if isinstance(tree, str) else tree
        assert isinstance(ranking, tuple)
        self._names(ranking, steps)
        return ranking

    def _reward(self) -> Tree[float] | None:
        tree = self._document.reward
        return None if tree is None else self._trees.read(tree, ("reward",), lambda p, _: float(p))

    def _tried(self) -> Mapping[str, tuple[float, float]]:
        """Return the tried range of each component, and report unknown components."""
        for name in self._document.tried:
            if name not in self._dimensions:
                self._trees.report_unknown(name, self._source.key("tried", name))
        return self._document.tried

    def _names(self, ranking: Ranking, steps: Steps) -> None:
        known = list(self._document.allocations)
        for name in ranking:
            if name not in known:
                self._diagnostics.add("CB640", self._source.place(*steps), names=known, name=name)


def _abstract(controller: Controller) -> tuple[str, str, str]:
    """Return a controller's declarative part (Eq 5.1): potential, and types of its signals."""
    return (
        controller.potential,
        str(controller.feedback.type.name),
        str(controller.effector.type.name),
    )
