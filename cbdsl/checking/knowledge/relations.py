"""Checks of relations documents: their questions and their samples."""

from __future__ import annotations

from typing import Any

from cbdsl.checking.question_tree import QuestionTrees, Steps
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
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


def relation_tree(loaded: Loaded[RelationsDocument], diagnostics: Diagnostics) -> Tree[str]:
    """Return the tree of a document, in SI units."""

    def name(leaf: Any, _: Steps) -> str:
        return str(leaf)

    trees = QuestionTrees(loaded.source, diagnostics, _UNITS, {})
    return trees.read(loaded.document.tree, ("tree",), name)
