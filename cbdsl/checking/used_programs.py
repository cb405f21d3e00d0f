"""Programs that a program uses as actions, each with values and perhaps a policy of its own."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from cbdsl.checking.dependencies import Dependencies
from cbdsl.checking.knowledge.policy_agreement import check_policy, with_policy
from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.lookup.scope import Scope
from cbdsl.checking.program_context import Steps
from cbdsl.checking.session import Session
from cbdsl.checking.substitution import Examine
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument, Use
from cbdsl.program.checked import CheckedProgram
from cbdsl.types.role import ROBOT
from cbdsl.yaml_text.loaded import Loaded

if TYPE_CHECKING:
    from cbdsl.documents.schema import SchemaDocument

K = TypeVar("K", PolicyDocument, "SchemaDocument")

# Bounds on nested programs, and on all used programs, each with other values.
_DEEPEST = 64
_MOST = 256
# Diagnostics after which further checks with other values would not end.
_ENDLESS = frozenset({"CB409", "CB605", "CB610"})


class Budget:
    """Budget of the uses below one program, which could multiply without bounds.

    Attributes:
        depth: Number of programs within one another.
        count: Number of programs checked so far.
    """

    def __init__(self) -> None:
        self.depth = 0
        self.count = 0

    @property
    def ended(self) -> bool:
        """True if there are more programs than any realistic document has."""
        return self.depth > _DEEPEST or self.count > _MOST


class UsedPrograms:
    """Checks of the programs that one program uses.

    Args:
        loaded: Program that uses them.
        session: Session with the documents read so far.
        diagnostics: Diagnostics so far.
        dependencies: Dependencies with the robot that all of them have to be for.
        scope: Values of the program's parameters.
        budget: Budget of nested programs, shared with the programs above.
        examine: Check of a program with some values of its parameters.
    """

    def __init__(
        self,
        loaded: Loaded[ProgramDocument],
        session: Session,
        diagnostics: Diagnostics,
        dependencies: Dependencies,
        scope: Scope,
        budget: Budget,
        examine: Examine,
    ) -> None:
        self._loaded, self._source = loaded, loaded.source
        self._session, self._diagnostics = session, diagnostics
        self._dependencies, self._scope = dependencies, scope
        self._budget, self._examine = budget, examine
        self._unsuitable: list[tuple[str, Path, str, Diagnostics]] = []

    def check(self) -> dict[str, Outcome[CheckedProgram]]:
        """Return the used programs by their names here; one that cannot run is unknown."""
        return {name: self._use(name, use) for name, use in self._loaded.document.use.items()}

    def _use(self, name: str, use: Use) -> Outcome[CheckedProgram]:
        steps: Steps = ("use", name, "program")
        path = self._find(use, steps)
        if isinstance(path, Unknown):
            return UNKNOWN
        try:
            used = self._session.library.read_as_written(path, ProgramDocument)
        except DiagnosticsError as error:
            self._diagnostics.extend(error.diagnostics)
            return UNKNOWN
        robot = used.document.robot or self._loaded.document.robot
        if not self._dependencies.is_for_the_robot(robot, use.program, steps):
            return UNKNOWN
        values, parts = self._values(name, use, used), self._parts(used.document)
        faults = Diagnostics()
        program = self._examine(path, {**parts, **values}, faults)
        # A program may fail with the given values because of these values, or because of faults of
        # its own. A second check with its default values decides. Faults of values are reported
        # here, where the values are written.
        if faults.failed and not faults.holds(_ENDLESS):
            own = Diagnostics()
            self._examine(path, parts, own)
            if not own.failed:
                # A value that is missing because of its own error may be needed to run.
                given = self._source.known(use.with_, "use", name, "with")
                if not isinstance(given, Unknown) and len(values) == len(given):
                    # Each value is tried alone beside the defaults. If only their combination
                    # fails, the first value is reported.
                    wrong = [k for k in values if not self._runs(path, {**parts, k: values[k]})]
                    self._unsuitable.append((name, path, (*wrong, *values)[0], faults))
                return UNKNOWN
            faults = own  # errors with its own values, too
        self._diagnostics.extend(faults.sorted())
        if use.schema_ is not None and use.policy is not None:
            details = {"name": name, "schema": use.schema_, "policy": use.policy}
            self._diagnostics.add("CB649", self._source.key("use", name, "policy"), **details)
        if isinstance(program, Unknown):
            return UNKNOWN
        return self._decided(name, use, program, path, values)

    def _parts(self, used: ProgramDocument) -> dict[str, str]:
        """Return the robot, and the effectors in roles of the same name, for a used program."""
        own = self._loaded.document
        if not used.roles:
            return {}
        chosen = {name: own.parameters[name] for name in own.roles if name in own.parameters}
        same = {name: value for name, value in chosen.items() if name in used.roles}
        return {ROBOT: own.robot, **same}

    def _decided(
        self, name: str, use: Use, program: CheckedProgram, path: Path, values: Mapping[str, str]
    ) -> Outcome[CheckedProgram]:
        """Return a used program under the schema or the policy that its use names."""
        if use.schema_ is not None:
            return self._allocated(use.schema_, program, values, ("use", name, "schema"))
        if use.policy is None:
            return program
        return self._learned(use.policy, program, path, ("use", name, "policy"))

    def _runs(self, path: Path, values: Mapping[str, str]) -> bool:
        """Return whether a program has no errors with some values of its parameters."""
        diagnostics = Diagnostics()
        self._examine(path, values, diagnostics)
        return not diagnostics.failed

    def report_values(self, reported: Collection[str]) -> None:
        """Report values with which used programs cannot run.

        Args:
            reported: Parameters of this program whose values have been reported.
        """
        source = self._source
        for name, path, key, faults in self._unsuitable:
            text = self._loaded.document.use[name].with_[key]
            if text.startswith("$") and text[1:] in reported:
                continue
            fault = next(fault for fault in faults.sorted() if fault.is_error)
            passed_on = self._scope.place(text[1:]) if text.startswith("$") else None
            here = source.place("use", name, "with", key)
            self._diagnostics.add(
                "CB609",
                passed_on or here,
                names=fault.allowed,
                candidates=fault.candidates,
                given=fault.given,
                related=[(here, "it is passed on here"), (fault.place, "it is used here")],
                program=path.stem,
                name=key,
                problem=fault.message,
            )

    def _find(self, use: Use, steps: Steps) -> Outcome[Path]:
        """Return the file of a program that can be used here."""
        source = self._source
        path = self._dependencies.find(ProgramDocument, use.program, steps)
        if isinstance(path, Unknown):
            return UNKNOWN
        path_back = self._session.uses.find_path(path, self._loaded.path)
        if path_back:
            cycle = " → ".join(file.stem for file in (path_back[-1], *path_back))
            self._diagnostics.add(
                "CB605", source.place(*steps), name=path_back[-1].stem, cycle=cycle
            )
            return UNKNOWN
        if self._budget.ended:
            self._diagnostics.add("CB610", source.place(*steps), depth=_DEEPEST, bound=_MOST)
            return UNKNOWN
        return path

    def _values(self, name: str, use: Use, used: Loaded[ProgramDocument]) -> dict[str, str]:
        """Return the parameters of a used program, with this program's own replaced."""
        source, values = self._source, {}
        parameters = used.source.declared(used.document.assignable, "parameters")
        for key, text in use.with_.items():
            steps = ("use", name, "with", key)
            if key not in parameters:
                details = {"name": key, "program": use.program}
                self._diagnostics.add(
                    "CB606", source.key(*steps), names=list(parameters), **details
                )
                continue
            value = self._scope.substitute(text, source, steps, self._diagnostics)
            if not isinstance(value, Unknown):
                values[key] = value
        return values

    def _allocated(
        self, name: str, program: CheckedProgram, values: Mapping[str, str], steps: Steps
    ) -> Outcome[CheckedProgram]:
        """Return a used program that a schema allocates; unknown if the schema does not fit."""
        # Few programs use schemas, and their module takes a fiftieth of cb validate's time.
        from cbdsl.checking.schema import checked_schema
        from cbdsl.documents.schema import SchemaDocument

        loaded = self._knowledge(SchemaDocument, name, program, steps)
        if isinstance(loaded, Unknown):
            return UNKNOWN
        return checked_schema(loaded, self._session, self._diagnostics, self._examine, values)

    def _learned(
        self, name: str, program: CheckedProgram, path: Path, steps: Steps
    ) -> Outcome[CheckedProgram]:
        """Return a used program under its own policy; unknown if the policy does not fit."""
        loaded = self._knowledge(PolicyDocument, name, program, steps)
        if isinstance(loaded, Unknown):
            return UNKNOWN
        diagnostics = Diagnostics()
        check_policy(loaded, program, path, self._session, diagnostics)
        self._diagnostics.extend(diagnostics.sorted())
        if diagnostics.failed:
            return UNKNOWN
        return with_policy(program, loaded, self._session.library)

    def _knowledge(
        self, kind: type[K], name: str, program: CheckedProgram, steps: Steps
    ) -> Outcome[Loaded[K]]:
        """Return a used program's policy or schema, if it is for this program."""
        place, library = self._source.place(*steps), self._session.library
        file = find_document(kind, name, place, library, self._diagnostics)
        loaded = self._session.read(file, kind, self._diagnostics)
        if isinstance(loaded, Unknown) or loaded.document.program == program.name:
            return loaded
        details = {"name": name, "other": loaded.document.program, "program": program.name}
        self._diagnostics.add("CB626", place, **details)
        return UNKNOWN
