"""Shipped relations follow from their own samples, and name most of them right."""

from __future__ import annotations

import pytest

from cbdsl.api.reading.relations import read_relation_tree, read_relations
from cbdsl.documents.relations import RELATIONS
from cbdsl.learning.catalogs.relation_tree import NamedImpedance, grow_relations
from cbdsl.types.decision_tree import decide
from cbdsl.types.direction import DIRECTIONS
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

SHIPPED = [path.stem for path in sorted((ROOT / RELATIONS.folder).glob("*.yaml"))]


@pytest.mark.parametrize("name", SHIPPED)
def test_tree_of_shipped_relations_is_the_tree_of_their_samples(name: str) -> None:
    library = Library()
    samples = read_relations(name, library).document.samples
    known = [
        NamedImpedance(dict(zip(DIRECTIONS, sample, strict=True)), relation)
        for relation, own in samples.items()
        for sample in own
    ]
    tree = read_relation_tree(name, library)
    assert tree == grow_relations(known)
    right = sum(decide(tree, each.impedances) == each.relation for each in known)
    assert right >= 0.95 * len(known)


def test_contacts_go_on_from_shipped_relations() -> None:
    provenance = read_relations("contacts", Library()).document.provenance
    assert provenance is not None and provenance.earlier is not None
    assert provenance.earlier.name in SHIPPED
