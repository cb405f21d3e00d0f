"""``cbdsl.explore`` and ``cbdsl.explore_pairs``: catalogs of affordances, from actions."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cbdsl.api.requests.declaration import verb
from cbdsl.api.requests.explore_pairs_request import ExplorePairsRequest
from cbdsl.api.requests.explore_request import ExploreRequest

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.catalog import CatalogDocument
    from cbdsl.documents.meta_catalog import MetaCatalogDocument
    from cbdsl.training.exploration.action_work import FinishedAction


@dataclass(frozen=True)
class ExplorationOutcome:
    """Knowledge from one exploration.

    Attributes:
        catalog: File of the catalog.
        journal: File with a line for each action.
        document: Catalog with the rewards of each action and the models of their features.
    """

    catalog: Path
    journal: Path
    document: CatalogDocument

    @property
    def rewarded(self) -> dict[str, tuple[int, int]]:
        """Numbers of rewarded and of all tries, by action."""
        sections = self.document.affordances.items()
        return {name: (section.rewarded, section.tried) for name, section in sections}


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


@verb(ExploreRequest)
def explore(request: ExploreRequest) -> ExplorationOutcome:
    """Explore the affordances of an object, in this process.

    A file beside the catalog's holds each action as soon as it is over. With ``resume`` an
    interrupted exploration continues in a new world.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or a file is in the way.
        OSError: A file cannot be written.
    """
    run, task = request.task()
    # Joining goes on with the journal, too, and therefore allows that it exists.
    task.require_ready(resume=request.resume or request.join)
    return ExplorationOutcome(task.path, task.journal, _done(task, run, request))


@verb(ExplorePairsRequest)
def explore_pairs(request: ExplorePairsRequest) -> PairExplorationOutcome:
    """Explore the pairs of objects that a program brings together, in this process.

    A file beside the meta-catalog's holds each action as soon as it is over. With ``resume`` an
    interrupted exploration continues.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or a file is in the way.
        OSError: A file cannot be written.
    """
    run, task = request.task()
    task.require_ready(resume=request.resume)
    return PairExplorationOutcome(task.path, task.journal, _done(task, run, request))


def _done(task: Any, run: RunRequest, request: ExploreRequest | ExplorePairsRequest) -> Any:
    """Run a task, and return the document that it writes."""
    from cbdsl.api.open_robot import open_robot
    from cbdsl.training.task_observer import ItemListener

    def note(action: FinishedAction) -> None:
        if request.on_action is not None:
            request.on_action(action.outcome, action.step)

    with open_robot(run, backend=task.backend, cameras=request.cameras) as robot:
        return task.run(robot.backend, robot.kinematics, ItemListener(note))
