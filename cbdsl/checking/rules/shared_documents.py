"""Shared documents by themselves: each part with the values to check it with."""

from __future__ import annotations

from pathlib import Path

from cbdsl.checking.dependencies import Dependencies
from cbdsl.checking.lookup.scope import Scope
from cbdsl.checking.program_context import ProgramContext
from cbdsl.checking.rules.compositions import Compositions
from cbdsl.checking.rules.conditions import check_conditions
from cbdsl.checking.session import Session
from cbdsl.checking.sound_controllers import SoundControllers
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.shared import SharedDocument
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.shared_parts import as_program, shared_parts, unused_parameters


def check_shared(
    loaded: Loaded[SharedDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check the parts of a shared document with the values of its parameters."""
    parts, source = shared_parts(loaded, diagnostics), loaded.source
    if source.broken.holds("robot"):
        return
    text = session.library.text(loaded.path)
    program = as_program(loaded, parts, text, diagnostics.sorted())
    diagnostics.extend(program.diagnostics)
    values = source.declared(program.document.parameters, "parameters")
    places = {name: source.place("parameters", name) for name in program.document.parameters}
    dependencies = Dependencies(program, session, diagnostics)
    context = ProgramContext(
        program,
        dependencies.body(),
        Scope(values, places),
        diagnostics,
        dependencies.is_unknown,
        SoundControllers(),
    )
    Compositions(context).check_all()
    check_conditions(context)
    if not diagnostics.failed:  # a part may use its parameters in a text with a fault
        diagnostics.extend(unused_parameters(loaded, parts).sorted())


def faults_of_shared(path: Path, session: Session) -> Diagnostics:
    """Return the diagnostics of the shared documents that a program takes up, each by itself."""
    faults, library = Diagnostics(), session.library
    try:
        document = library.read_as_written(path, ProgramDocument).document
        for name in document.shared:
            file = library.find(SharedDocument, name, path)
            if file is not None:
                loaded = library.read_sound_parts(file, SharedDocument)
                faults.extend(loaded.diagnostics)
                check_shared(loaded, session, faults)
    except DiagnosticsError as error:
        faults.extend(error.diagnostics)
    return faults
