"""Request to explore: one object for ``cb explore`` and ``cbdsl.explore``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.api.requests.declaration import (
    BACKEND,
    CAMERAS,
    COMMAND,
    CONSTANTS,
    FOLDER,
    SEED,
    call_text,
    declaration,
    engine_of,
    given,
    load_text,
)

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.stage import StageDocument
    from cbdsl.learning.catalogs.action_outcome import ActionOutcome
    from cbdsl.learning.catalogs.exploration import ExplorationStep
    from cbdsl.training.exploration.exploration_task import ExplorationTask


_GROUP = "Exploration options"


@declaration
class ExploreRequest:
    """Exploration of an object's affordances, with all its inputs."""

    programs: Sequence[str | RunRequest] = given(
        "Actions, as ``NAME``, ``NAME:key=value`` or ``LABEL=NAME:key=value``; the value ``?`` "
        "stands for each channel that the run detects. Or results of ``load``, whose stages do not "
        "count.",
        kw_only=False,
        kind=list[str],
        help="Actions: programs, as NAME, NAME:key=value, or LABEL=NAME:key=value. The value ? "
        "stands for each channel that the run detects.",
        flag="-",
        metavar="PROGRAM",
    )
    stage: str | Path = given(
        "Stage with a persistent world: file or name.", kw_only=False, kind=str, group=_GROUP
    )
    out: str | Path = given("File for the catalog, ``NAME.yaml``.", kw_only=False, kind=Path)
    feature: str = given(
        "Channel of the object, for all programs with the parameter ``feature``.",
        default="sat_10",
        kind=str,
        group=_GROUP,
    )
    actions: int = given(
        "Number of actions.", default=100, always=True, kind=int, group=_GROUP, min=1
    )
    until_habituated: bool = given(
        "True to end when all models have habituated.",
        default=False,
        kind=bool,
        help="End when all models have habituated.",
        group=_GROUP,
    )
    seed: int = given(SEED, default=0, always=True, group=_GROUP)
    number: int = given("Number of this exploration among several with this seed.", default=0)
    backend: str | None = given(BACKEND, default=None, always=True, group=_GROUP)
    cameras: str | None = given(CAMERAS, default=None, group=_GROUP)
    between: str = given(
        "Program that runs after each action, such as to release the object.",
        default="let_go",
        kind=str,
        group=_GROUP,
    )
    algorithm: str = given(
        "Algorithm: ``explore_catalog`` (Algorithm 3) or ``explore_models`` (Section 6.3).",
        default="explore_catalog",
        kind=str,
        group=_GROUP,
    )
    constants: Mapping[str, str | float] = given(CONSTANTS, default_factory=dict)
    resume: bool = given(
        "True to continue an exploration that was begun there.", default=False, recorded=False
    )
    join: bool = given(
        "True to continue it with additional programs, or with a changed stage.",
        default=False,
        kind=bool,
        help="Continue with additional programs, or with a changed --stage.",
    )
    folder: Path | None = given(FOLDER, default=None)
    command: str = given(COMMAND, default="", recorded=False)
    on_action: Callable[[ActionOutcome, ExplorationStep], None] | None = given(
        "Function called with the outcome of each new action, and with its reward.",
        default=None,
        recorded=False,
    )

    def task(self) -> tuple[RunRequest, ExplorationTask]:
        """Return the first action with robot and stage, and the task, ready to run.

        Raises:
            DiagnosticsError: A document has errors.
            UsageError: An item is unknown or unsuitable.
        """
        from cbdsl.api.requests.explored_actions import read_actions
        from cbdsl.api.requests.load_request import LoadOptions
        from cbdsl.diagnostics.errors import UsageError
        from cbdsl.learning.catalogs.explorations import EXPLORATIONS
        from cbdsl.learning.constants import read_constants
        from cbdsl.training.exploration.exploration_task import ExplorationTask

        path, stage = Path(self.out), str(self.stage)
        if path.suffix != ".yaml":
            raise UsageError(f"{path}: a catalog is <name>.yaml")
        if self.algorithm not in EXPLORATIONS:
            raise UsageError.unknown("exploration", self.algorithm, EXPLORATIONS)
        requests, explorable = read_actions(self.programs, self.feature, stage, self.folder)
        run = requests[0]
        require_persistent(run.stage)
        constants = EXPLORATIONS[self.algorithm].Constants
        return run, ExplorationTask(
            actions=explorable,
            between=LoadOptions(stage=stage, folder=self.folder).read(self.between).program,
            feature=self.feature,
            robot=run.robot,
            # Absolute paths remain valid in processes with other working folders.
            urdf=run.urdf.absolute(),
            stage=run.stage,
            backend=engine_of(self),
            algorithm=self.algorithm,
            constants=read_constants(constants, self.constants, self.algorithm),
            seed=self.seed,
            number=self.number,
            count=self.actions,
            until_habituated=self.until_habituated,
            command=self.command or self._call(),
            path=path.absolute(),
            cameras=self.cameras,
            joins=self.join,
        )

    def _call(self) -> str:
        """Return the call in Python that repeats the exploration."""
        programs = (
            repr(each) if isinstance(each, str) else load_text(each, each.values)
            for each in self.programs
        )
        texts = {"programs": f"[{', '.join(programs)}]", "stage": repr(str(self.stage))}
        return call_text("cbdsl.explore", self, **texts, out=repr(Path(self.out).name))


def require_persistent(stage: StageDocument) -> None:
    """Check that actions can follow each other in one world.

    Raises:
        UsageError: The stage begins each action in a new world.
    """
    from cbdsl.diagnostics.errors import UsageError

    if not stage.world.persistent:
        raise UsageError(
            f"stage '{stage.name}' has no persistent world, in which one action follows another: "
            "give it world: {persistent: true}"
        )
