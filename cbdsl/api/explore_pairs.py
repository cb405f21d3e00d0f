"""``cbdsl.explore_pairs``: a meta-catalog of the pairs of some objects, from actions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.documents.meta_catalog import MetaCatalogDocument
    from cbdsl.learning.catalogs.action_outcome import ActionOutcome
    from cbdsl.learning.catalogs.exploration import ExplorationStep


@dataclass(frozen=True)
class PairExplorationOutcome:
    """Knowledge from one exploration of pairs.

    Attributes:
        catalog: File of the meta-catalog.
        journal: File with a line for each action.
        document: Meta-catalog with the rewards of each pair and the models of their features.
    """

    catalog: Path
    journal: Path
    document: MetaCatalogDocument

    @property
    def rewarded(self) -> dict[str, tuple[int, int]]:
        """Numbers of rewarded and of all tries, by pair."""
        sections = self.document.pairs.items()
        return {name: (section.rewarded, section.tried) for name, section in sections}


def explore_pairs(
    program: str,
    things: Mapping[str, str],
    stage: str | Path,
    out: str | Path,
    *,
    relation: str = "on",
    actions: int = 100,
    until_habituated: bool = False,
    seed: int = 0,
    backend: str | None = None,
    cameras: str | None = None,
    constants: Mapping[str, str | float] | None = None,
    relations: str | Path | None = None,
    resume: bool = False,
    on_action: Callable[[ActionOutcome, ExplorationStep], None] | None = None,
) -> PairExplorationOutcome:
    """Explore the pairs of objects that a program brings together, in this process.

    A file beside the meta-catalog's holds each action as soon as it is over. With ``resume`` an
    interrupted exploration continues.

    Args:
        program: Program that brings one object to another, as ``NAME`` or ``NAME:key=value``.
        things: Channel of each object, by name. A stack has the name of its pair in a meta-catalog,
            and ``@`` with the name of this meta-catalog instead of a channel.
        stage: File or name of a stage with a context for each pair, such as ``ball_on_box``.
        out: File for the meta-catalog, ``NAME.yaml``.
        relation: Relation that the program brings about, ``on`` or ``in``.
        actions: Largest number of actions.
        until_habituated: True to end when all models have habituated.
        seed: Seed of all random draws.
        backend: Name of the backend, as for ``open_robot``.
        cameras: Kind of cameras, as for ``open_robot``.
        constants: Constants of the exploration, by name, in SI or as text with units.
        relations: Relations that name the contacts that the program tests: file or name.
        resume: True to continue an exploration that was begun there.
        on_action: Function called with the outcome of each new action, and with its reward.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or a file is in the way.
        OSError: A file cannot be written.
    """
    from cbdsl.api.explore import listener
    from cbdsl.api.open_robot import open_robot
    from cbdsl.api.requests.explore_pairs_request import ExplorePairsRequest
    from cbdsl.backends.engines import default_engine

    request = ExplorePairsRequest(
        program=program,
        things=dict(things),
        stage=str(stage),
        out=Path(out),
        relation=relation,
        actions=actions,
        until_habituated=until_habituated,
        seed=seed,
        backend=default_engine() if backend is None else backend,
        cameras=cameras,
        constants=dict(constants or {}),
        relations=None if relations is None else str(relations),
    )
    run, task = request.task()
    task.require_ready(resume=resume)
    with open_robot(run, backend=task.backend, cameras=cameras) as robot:
        document = task.run(robot.backend, robot.kinematics, listener(on_action))
    return PairExplorationOutcome(task.path, task.journal, document)
