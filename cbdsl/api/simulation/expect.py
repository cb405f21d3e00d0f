"""Predictions of a catalog in new scenes, beside the outcomes there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.training.held_out import Prediction

# Time after which an action has failed, s, as in explorations.
_LONGEST = 60.0


def expect(
    catalog: str | Path,
    stage: str | Path | None = None,
    *,
    seed: int,
    scenes: int | Sequence[int] = 100,
    backend: str | None = None,
    cameras: str | None = None,
    on_prediction: Callable[[Prediction], None] = lambda prediction: None,
) -> list[Prediction]:
    """Predict the reward of a catalog's actions in new scenes, and take them.

    Each scene has one action; all have their turns.

    Args:
        catalog: File or name of the catalog.
        stage: File or name of a persistent stage; that of the exploration if ``None``.
        seed: Seed of all random draws.
        scenes: Number of scenes, or the number of each.
        backend: Name of the backend, as for ``open_robot``.
        cameras: Kind of cameras, as for ``open_robot``.
        on_prediction: Function called with each prediction and its outcome.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed, or does not fit.
    """
    from cbdsl.api.load import load
    from cbdsl.api.open_robot import open_robot
    from cbdsl.api.reading.clean import require_clean
    from cbdsl.api.requests.explore_request import require_persistent
    from cbdsl.api.requests.explored_actions import recorded_actions
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.documents.catalog import CatalogDocument
    from cbdsl.training.exploration.action_runner import ActionRunner
    from cbdsl.training.held_out import try_scenes
    from cbdsl.yaml_text.library import Library

    library = Library()
    file = library.locate(CatalogDocument, str(catalog))
    require_clean(file, library)
    document = library.read(file, CatalogDocument).document
    # A catalog that was written by hand reaches this.
    if stage is None and document.provenance is None:
        raise UsageError(f"{file}: no provenance names a stage; give one")
    shown = str(stage or (document.provenance and document.provenance.stage.name))
    request, actions = recorded_actions(document, shown)
    require_persistent(request.stage)
    # As in explorations, this program makes the robot ready for the next action.
    between = load("let_go", stage=shown)
    with open_robot(request, backend=backend, cameras=cameras) as robot:
        runner = ActionRunner(
            request.robot,
            robot.kinematics,
            robot.backend,
            request.stage,
            actions,
            between.program,
            _LONGEST,
        )
        numbers = range(scenes) if isinstance(scenes, int) else scenes
        return try_scenes(document, runner, numbers, seed, on_prediction)
