"""Whether stacks of three stand if a meta-catalog alone plans them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cbdsl_reproduction.judges.judge import Aim, BodyChoice, EpisodeVerdict, Judge, JudgedCondition


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each planned stack."""
    from cbdsl.documents.meta_catalog import MetaCatalogDocument
    from cbdsl.yaml_text.library import Library
    from cbdsl_reproduction.planned_stacks import run_planned

    library = Library()
    file = library.locate(MetaCatalogDocument, condition.name)
    catalog = library.read(file, MetaCatalogDocument).document
    for trial in run_planned(catalog, seeds, body.backend, body.cameras):
        measures = {"expected_percent": 100 * trial.expected}
        yield EpisodeVerdict(
            trial.seed, {"stands": trial.stands}, float("nan"), trial.ending, measures, trial.things
        )


JUDGE = Judge(
    "planned_stacks",
    "stacks of three that a meta-catalog plans",
    (JudgedCondition("four_things", "stack_three", {"stands": Aim(0.5)}),),
    _measure,
    BodyChoice("mujoco", "ideal"),
)
