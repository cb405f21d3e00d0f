"""Checks of relations documents: their questions and their samples."""

from __future__ import annotations

from typing import Any

from cbdsl.checking.question_tree import QuestionTrees, Steps
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.relations import RelationsDocument
from cbdsl.types.decision_tree import Tree, leaves
from cbdsl.types.direction import DIRECTIONS, unit_of
from cbdsl.yaml_text.loaded import Loaded

_UNITS = {direction: unit_of(direction) for direction in DIRECTIONS}


def examine_relations(
    loaded: Loaded[RelationsDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check that the questions are about impedances, and that samples have the named relations."""
    if loaded.diagnostics:
        return  # a tree with missing parts cannot be checked
    tree = relation_tree(loaded, diagnostics)
    document, source = loaded.document, loaded.source
    if document.samples:
        for name in sorted({*leaves(tree)} - document.samples.keys()):
            diagnostics.add("CB681", source.place("tree"), names=list(document.samples), name=name)
    _check_program(loaded, session, diagnostics)


def _check_program(
    loaded: Loaded[RelationsDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check that the program of the tests is the one with which the samples were measured."""
    # Only learned relations need it.
    from cbdsl.checking.knowledge.program_digest import program_digest

    document, library = loaded.document, session.library
    provenance = document.provenance
    path = library.find(ProgramDocument, document.program, loaded.path)
    if provenance is None or path is None:
        return
    if program_digest(path, library, document.robot).sha256 != provenance.program.sha256:
        place = loaded.source.place("provenance", "program", "sha256")
        details = {"program": document.program, "command": provenance.command}
        diagnostics.add("CB622", place, **details)


def relation_tree(loaded: Loaded[RelationsDocument], diagnostics: Diagnostics) -> Tree[str]:
    """Return the tree of a document, in SI units."""

    def name(leaf: Any, _: Steps) -> str:
        return str(leaf)

    trees = QuestionTrees(loaded.source, diagnostics, _UNITS, {})
    return trees.read(loaded.document.tree, ("tree",), name)
