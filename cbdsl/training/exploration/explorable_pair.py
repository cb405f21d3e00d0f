"""Explorable pairs of objects, one of which can be brought to the other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.documents.document_digest import ProgramDigest
from cbdsl.learning.catalogs.action_outcome import FeatureForm
from cbdsl.program.checked import CheckedProgram
from cbdsl.types.resource import Resource


class ExplorablePair(NamedTuple):
    """Pair of objects, one of which can be brought to the other.

    Attributes:
        upper, lower: Names of the objects.
        context: Context of the stage that shows them.
        program: Program bound to their channels.
        digest: Digest of the program's text.
        features: Signals of both, by name.
    """

    upper: str
    lower: str
    context: str
    program: CheckedProgram
    digest: ProgramDigest
    features: Mapping[str, Resource]

    @property
    def forms(self) -> tuple[FeatureForm, ...]:
        """Forms of the features for a model."""
        return tuple(
            FeatureForm(name, resource.type.unit, resource.type.size)
            for name, resource in self.features.items()
        )
