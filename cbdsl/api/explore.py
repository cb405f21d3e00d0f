"""``cbdsl.explore``: a catalog of an object's affordances, from actions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.catalog import CatalogDocument
    from cbdsl.learning.catalogs.action_outcome import ActionOutcome
    from cbdsl.learning.catalogs.exploration import ExplorationStep
    from cbdsl.training.exploration.action_work import FinishedAction
    from cbdsl.training.task_observer import ItemListener


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


def explore(
    programs: Sequence[str | RunRequest],
    stage: str | Path,
    out: str | Path,
    *,
    feature: str = "sat_10",
    actions: int = 100,
    until_habituated: bool = False,
    seed: int = 0,
    backend: str | None = None,
    cameras: str | None = None,
    between: str = "let_go",
    algorithm: str = "explore_catalog",
    constants: Mapping[str, str | float] | None = None,
    resume: bool = False,
    join: bool = False,
    on_action: Callable[[ActionOutcome, ExplorationStep], None] | None = None,
) -> ExplorationOutcome:
    """Explore the affordances of an object, in this process.

    A file beside the catalog's holds each action as soon as it is over. With ``resume`` an
    interrupted exploration continues in a new world.

    Args:
        programs: Actions, as ``NAME``, ``NAME:key=value`` or ``LABEL=NAME:key=value``; the value
            ``?`` stands for each channel that the run detects. Or results of ``load``, whose stages
            do not count.
        stage: File or name of a stage with a persistent world.
        out: File for the catalog, ``NAME.yaml``.
        feature: Channel of the object, for all programs with the parameter ``feature``.
        actions: Largest number of actions.
        until_habituated: True to end when all models have habituated.
        seed: Seed of all random draws.
        backend: Name of the backend, as for ``open_robot``.
        cameras: Kind of cameras, as for ``open_robot``.
        between: File or name of the program that runs after each action.
        algorithm: ``explore_catalog`` (Algorithm 3) or ``explore_models`` (Section 6.3).
        constants: Constants of the algorithm, by name, in SI or as text with units.
        resume: True to continue an exploration that was begun there.
        join: True to continue it with additional programs, or with a changed stage.
        on_action: Function called with the outcome of each new action, and with its reward.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or a file is in the way.
        OSError: A file cannot be written.
    """
    from cbdsl.api.open_robot import open_robot
    from cbdsl.api.requests.explore_request import ExploreRequest
    from cbdsl.backends.engines import default_engine

    request = ExploreRequest(
        programs=tuple(programs),
        stage=str(stage),
        out=Path(out),
        feature=feature,
        actions=actions,
        until_habituated=until_habituated,
        seed=seed,
        backend=default_engine() if backend is None else backend,
        cameras=cameras,
        between=between,
        algorithm=algorithm,
        constants=dict(constants or {}),
        join=join,
    )
    run, task = request.task()
    # Joining goes on with the journal, too, and therefore allows that it exists.
    task.require_ready(resume=resume or join)
    with open_robot(run, backend=task.backend, cameras=cameras) as robot:
        document = task.run(robot.backend, robot.kinematics, listener(on_action))
    return ExplorationOutcome(task.path, task.journal, document)


def listener(
    on_action: Callable[[ActionOutcome, ExplorationStep], None] | None,
) -> ItemListener[FinishedAction]:
    """Return an observer that passes each new action to a function."""
    from cbdsl.training.task_observer import ItemListener

    def note(action: FinishedAction) -> None:
        if on_action is not None:
            on_action(action.outcome, action.step)

    return ItemListener(note)
