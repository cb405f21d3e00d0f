"""Whether stacks of three stand if a meta-catalog alone plans them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cbdsl_reproduction.judges.judge import Aim, BodyChoice, EpisodeVerdict, Judge, JudgedCondition


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each planned stack."""
    from cbdsl.api.documents import MetaCatalogDocument
    from cbdsl.api.shipped import shipped_document
    from cbdsl_reproduction.planned_stacks import run_planned

    catalog = shipped_document(MetaCatalogDocument, condition.name)
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
    knowledge=("meta_catalogs/four_things.yaml",),
)
