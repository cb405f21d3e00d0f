"""NAME_RELATIONS learns a teacher's names from complete profiles."""

from __future__ import annotations

from typing import Any, cast

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.relations import RelationsDocument
from cbdsl.learning.catalogs.name_relations import NameRelations, NameRelationsConstants
from cbdsl.learning.experience import Experience
from cbdsl.learning.impedance import UNTESTED, ImpedanceProfile
from cbdsl.learning.learner import LEARNERS, NAME_RELATIONS, TrialSummary
from tests.learning.profiles import FLAT, ROUND


class Impedance:
    """The parts of a program that documents name."""

    name, robot = "impedance", "dexter"


def experience(profile: ImpedanceProfile, relation: str) -> Experience:
    return Experience("a_on_b", 1, (), {}, 100, 2.0, profile=profile, relation=relation)


def learner(*episodes: tuple[ImpedanceProfile, str]) -> NameRelations:
    made = LEARNERS.get(NAME_RELATIONS)([], NameRelationsConstants(), {})
    assert isinstance(made, NameRelations)
    for profile, relation in episodes:
        made.remember(experience(profile, relation))
    return made


def document(made: NameRelations) -> RelationsDocument:
    summary = TrialSummary("touch", cast(Any, Impedance), {}, [], cast(Any, None))
    (written,) = made.documents(summary)
    assert isinstance(written, RelationsDocument)
    return written


BOTH = [(ROUND, "spherical"), (FLAT, "plane_on_plane")] * 3


def test_documents_hold_a_question_between_the_relations() -> None:
    written = document(learner(*BOTH))
    assert written.tree.if_.startswith("dRz > ") and written.tree.if_.endswith(" N m/rad")  # type: ignore[union-attr]
    assert {name: len(own) for name, own in written.samples.items()} == {
        "plane_on_plane": 3,
        "spherical": 3,
    }


@pytest.mark.parametrize("episode", [(UNTESTED, "spherical"), (ROUND, "")])
def test_remember_ignores_episodes_without_profile_or_name(
    episode: tuple[ImpedanceProfile, str],
) -> None:
    assert document(learner(*BOTH, episode)) == document(learner(*BOTH))


def test_recall_of_a_document_and_new_episodes_equals_learning_all_together() -> None:
    earlier = document(learner(*BOTH[:3]))
    later = learner()
    later.recall(earlier)
    for profile, relation in BOTH[3:]:
        later.remember(experience(profile, relation))
    whole = document(learner(*BOTH))
    assert document(later).tree == whole.tree
    assert {name: sorted(own) for name, own in document(later).samples.items()} == {
        name: sorted(own) for name, own in whole.samples.items()
    }


def test_documents_without_any_profile_is_a_usage_error() -> None:
    with pytest.raises(UsageError, match="nothing was learned"):
        document(learner((UNTESTED, "spherical")))
