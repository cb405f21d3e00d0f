"""Explorable pairs: two things, one of which can be brought to the other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.documents.digest import ProgramDigest
from cbdsl.learning.action_outcome import FeatureForm
from cbdsl.program.checked import CheckedProgram
from cbdsl.types.resource import Resource


class ExplorablePair(NamedTuple):
    """Two things, one of which can be brought to the other.

    Attributes:
        upper, lower: names of the things.
        context: of the stage that shows them.
        program: bound to their channels.
        digest: of its text.
        features: signals of both, by name.
    """

    upper: str
    lower: str
    context: str
    program: CheckedProgram
    digest: ProgramDigest
    features: Mapping[str, Resource]

    @property
    def forms(self) -> tuple[FeatureForm, ...]:
        """The features as a model sees them."""
        return tuple(
            FeatureForm(name, resource.type.unit, resource.type.size)
            for name, resource in self.features.items()
        )
