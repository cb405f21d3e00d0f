"""Programs recognise the pairs of their meta-catalog, and no others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.program import check_program
from cbdsl.types.resource import PairLikeness
from cbdsl.types.resource_type import LIKENESS

OWN = """\
cbdsl: 1
kind: program
name: own
robot: dexter
{key}controllers:
  is_pair:
    potential: {potential}
    reference: 0.001
    feedback: likeness.{pair}
    effector: head
    gain: 1 /s
    quiescence: {{rate: 1e-6, window: 0.5 s}}
actions: [is_pair]
"""
KEY = "meta_catalog: four_things\n"


def codes(folder: Path, text: str) -> list[str]:
    path = folder / "own.yaml"
    path.write_text(text, encoding="utf-8")
    return [each.code for each in check_document(path)]


def test_likeness_of_ensure_stacked_has_the_features_of_the_pair() -> None:
    program = check_program("ensure_stacked")
    feedback = program.conditions["is_pair"].resources[0]
    assert feedback.type == LIKENESS
    assert isinstance(feedback.source, PairLikeness)
    assert [each.name for each in feedback.source.features] == [
        "left.hue_9.to.blue",
        "stereo.hue_9.to.blue",
    ]


def test_likeness_is_one_at_the_mean_and_falls_with_the_distance() -> None:
    source = check_program("ensure_stacked").conditions["is_pair"].resources[0].source
    assert isinstance(source, PairLikeness)
    mean = np.asarray(source.model.rewarded.mean)
    aside = np.array([0.0, 0.0, 0.0, 0.1, 0.0, 0.0])
    values = [source.model.likeness(mean + k * aside) for k in (0, 1, 2, 3)]
    assert values[0] == 1.0
    assert sorted(values, reverse=True) == values
    assert values[3] < 1e-3


@pytest.mark.parametrize(
    ("key", "pair", "potential", "expected"),
    [
        (KEY, "purple_box_on_blue_box", "at_least", []),
        (KEY, "purple_box_on_blue_bx", "at_least", ["CB501"]),
        # This pair was tried, and never stayed.
        (KEY, "purple_box_on_basketball", "at_least", ["CB501"]),
        ("", "purple_box_on_blue_box", "at_least", ["CB501"]),
        ("meta_catalog: four_thing\n", "purple_box_on_blue_box", "at_least", ["CB660"]),
        (KEY, "purple_box_on_blue_box", "spring", ["CB503"]),
    ],
)
def test_program_with_a_likeness_is_checked(
    tmp_path: Path, key: str, pair: str, potential: str, expected: list[str]
) -> None:
    found = codes(tmp_path, OWN.format(key=key, pair=pair, potential=potential))
    assert [code for code in found if code < "CB7"] == expected
