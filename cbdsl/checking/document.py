"""Checks of documents of any kind, with all diagnostics in one pass."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.checking.cause_order import causes_first
from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown
from cbdsl.documents.document import Document
from cbdsl.documents.kinds import KINDS, kind_name, kind_of
from cbdsl.storage.contents import is_file
from cbdsl.types.relative import ANY_ROBOT
from cbdsl.types.role import ROBOT
from cbdsl.yaml_text.loaded import Loaded

if TYPE_CHECKING:
    from cbdsl.documents.program import ProgramDocument
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.documents.schema import SchemaDocument


def check_document(path: Path, session: Session | None = None) -> list[Diagnostic]:
    """Return all diagnostics in a document and in the documents it refers to; causes come first.

    Args:
        path: File of the document.
        session: Session with the documents read so far, and values of programs' parameters.

    Raises:
        PluginError: The checker of another package's document kind fails.
    """
    session, diagnostics = session or Session(), Diagnostics()
    try:
        loaded = session.library.read_as_written(path, Document)
        diagnostics.extend(loaded.diagnostics)
        _named_like_its_file(loaded, diagnostics)
        _references(loaded, session, diagnostics)
        _examine(loaded, session, diagnostics)
    except DiagnosticsError as error:
        diagnostics.extend(error.diagnostics)
    return causes_first(diagnostics.sorted(), session.library)


def check_robot(loaded: Loaded[RobotDocument], session: Session, diagnostics: Diagnostics) -> None:
    """Check a robot; the session keeps the result."""
    session.body(loaded.path, diagnostics)
    if loaded.document.calibration is not None:
        from cbdsl.checking.calibration import check_own_calibration

        check_own_calibration(loaded, session, diagnostics)


def check_program(
    loaded: Loaded[ProgramDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check a program with the session's values of its parameters."""
    from cbdsl.checking.program import examine_program  # robots and stages do without
    from cbdsl.checking.rules.stage_colors import check_on_stage

    known = {*loaded.document.assignable, *([ROBOT] if loaded.document.roles else ())}
    values = {key: value for key, value in session.values.items() if key in known}
    for robot in _robots(loaded, values, session):
        program = examine_program(loaded.path, {**values, **robot}, session, diagnostics)
        if not isinstance(program, Unknown) and not diagnostics.failed:
            check_on_stage(loaded, program, session, diagnostics)


def _robots(
    loaded: Loaded[ProgramDocument], values: Mapping[str, str], session: Session
) -> list[dict[str, str]]:
    """Return the values that name each robot of a program: all at hand that fill its roles."""
    if not loaded.document.roles or ROBOT in values:
        return [{}]
    from cbdsl.checking.roles import fitting_robots

    return [{ROBOT: name} for name in fitting_robots(loaded, session)] or [{}]


def check_schema(
    loaded: Loaded[SchemaDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check a schema and the program that it allocates."""
    from cbdsl.checking.program import examiner
    from cbdsl.checking.schema import checked_schema

    values = {key: robot for key, robot in session.values.items() if key == ROBOT}
    checked_schema(loaded, session, diagnostics, examiner(session), values)


def _named_like_its_file(loaded: Loaded[Document], diagnostics: Diagnostics) -> None:
    """Warn of a name that differs from the file's, by which documents on a disk are found."""
    name, path = loaded.document.name, loaded.path
    if name not in (path.stem, UNKNOWN) and is_file(path):
        diagnostics.add("CB704", loaded.source.place("name"), name=name, file=path.name)


def _references(loaded: Loaded[Document], session: Session, diagnostics: Diagnostics) -> None:
    """Check that the documents that top-level keys name exist."""
    library = session.library
    for key, kind in kind_of(type(loaded.document)).references.items():
        name, model = getattr(loaded.document, key), KINDS.get(kind).model
        if name and (key, name) != (ROBOT, ANY_ROBOT):
            find_document(model, name, loaded.source.place(key), library, diagnostics)


def _examine(loaded: Loaded[Document], session: Session, diagnostics: Diagnostics) -> None:
    name = kind_name(type(loaded.document))
    module, _, function = KINDS.get(name).checker.partition(":")
    try:
        getattr(import_module(module), function)(loaded, session, diagnostics)
    except DiagnosticsError:
        raise
    except Exception as error:
        if KINDS.is_builtin(name):
            raise
        reason = f"its checker fails on {loaded.path}: {type(error).__name__}: {error}"
        raise KINDS.fault(name, reason) from error
