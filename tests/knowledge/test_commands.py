"""Commands of shipped knowledge state all constants that differ from the defaults."""

from __future__ import annotations

import itertools
import shlex
from pathlib import Path

import pytest
import yaml

from cbdsl.documents.document import Section
from cbdsl.learning.catalogs.catalog_exploration import CatalogExploration
from cbdsl.learning.catalogs.explorations import EXPLORATIONS
from cbdsl.learning.learner import LEARNERS
from tests.conftest import ROOT

LEARNED = [
    path
    for folder in ("policies", "schemas", "catalogs", "meta_catalogs")
    for path in sorted((ROOT / "knowledge" / folder).glob("*.yaml"))
]


def defaults(algorithm: str) -> Section:
    known = {**LEARNERS.all(), **EXPLORATIONS, "explore_pairs": CatalogExploration}
    return known[algorithm].Constants()


@pytest.mark.parametrize("path", LEARNED, ids=lambda path: path.stem)
def test_command_sets_the_constants_that_differ_from_the_defaults(path: Path) -> None:
    provenance = yaml.safe_load(path.read_text("utf-8"))["provenance"]
    usual = defaults(provenance["algorithm"]).model_dump()
    words = shlex.split(provenance["command"])
    pairs = itertools.pairwise(words)
    given = {word.split("=", 1)[0] for before, word in pairs if before == "--set"}
    given |= {word[2:].replace("-", "_") for word in words if word.startswith("--")}
    differing = {
        name
        for name, value in provenance["constants"].items()
        if name in usual and value != usual[name]
    }
    assert differing <= given
