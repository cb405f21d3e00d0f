"""Request to explore: one object for ``cb explore`` and ``cbdsl.explore``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.stage import StageDocument
    from cbdsl.training.exploration.exploration_task import ExplorationTask


@dataclass(frozen=True)
class ExploreRequest:
    """Exploration of an object's affordances, with all its inputs.

    Attributes:
        programs: Actions, as ``NAME``, ``NAME:key=value`` or ``LABEL=NAME:key=value``; the value
            ``?`` stands for each channel that the run detects. Or loaded programs.
        stage: Stage with a persistent world: file or name.
        out: File for the catalog, ``NAME.yaml``.
        feature: Channel of the object, for all programs with the parameter ``feature``.
        actions: Largest number of actions.
        until_habituated: True to end when all models have habituated.
        seed: Seed of all random draws.
        number: Number of this exploration among several with this seed.
        backend: Name of the backend; the first installed one if ``None``.
        cameras: Kind of the backend's cameras; the backend's default if ``None``.
        between: Program that runs after each action.
        algorithm: ``explore_catalog`` (Algorithm 3) or ``explore_models`` (Section 6.3).
        constants: Constants of the algorithm by name, as text with units or in SI.
        join: True to continue with additional programs, or with a changed stage.
        folder: Folder to search for documents by name; the working folder if ``None``.
        command: Command that repeats the exploration, for the provenance of the catalog.
    """

    programs: Sequence[str | RunRequest]
    stage: str
    out: Path
    feature: str = "sat_10"
    actions: int = 100
    until_habituated: bool = False
    seed: int = 0
    number: int = 0
    backend: str | None = None
    cameras: str | None = None
    between: str = "let_go"
    algorithm: str = "explore_catalog"
    constants: Mapping[str, str | float] = field(default_factory=dict)
    join: bool = False
    folder: Path | None = None
    command: str = ""

    def task(self) -> tuple[RunRequest, ExplorationTask]:
        """Return the first action with robot and stage, and the task, ready to run.

        Raises:
            DiagnosticsError: A document has errors.
            UsageError: An item is unknown or unsuitable.
        """
        from cbdsl.api.requests.explored_actions import read_actions
        from cbdsl.api.requests.run_request import read_request
        from cbdsl.backends.engines import default_engine
        from cbdsl.diagnostics.errors import UsageError
        from cbdsl.learning.catalogs.explorations import EXPLORATIONS
        from cbdsl.learning.constants import read_constants
        from cbdsl.training.exploration.exploration_task import ExplorationTask

        if self.out.suffix != ".yaml":
            raise UsageError(f"{self.out}: a catalog is <name>.yaml")
        if self.algorithm not in EXPLORATIONS:
            raise UsageError.unknown("exploration", self.algorithm, EXPLORATIONS)
        requests, explorable = read_actions(self.programs, self.feature, self.stage, self.folder)
        run = requests[0]
        require_persistent(run.stage)
        constants = EXPLORATIONS[self.algorithm].Constants
        return run, ExplorationTask(
            actions=explorable,
            between=read_request(self.between, self.stage, None, {}, folder=self.folder).program,
            feature=self.feature,
            robot=run.robot,
            # Absolute paths remain valid in processes with other working folders.
            urdf=run.urdf.absolute(),
            stage=run.stage,
            backend=default_engine() if self.backend is None else self.backend,
            algorithm=self.algorithm,
            constants=read_constants(constants, self.constants, self.algorithm),
            seed=self.seed,
            number=self.number,
            count=self.actions,
            until_habituated=self.until_habituated,
            command=self.command or self._call(),
            path=self.out.absolute(),
            cameras=self.cameras,
            joins=self.join,
        )

    def _call(self) -> str:
        """Return the call in Python that repeats the exploration."""
        from cbdsl.api.requests.call_text import call_text, chosen, load_text

        programs = (
            repr(each) if isinstance(each, str) else load_text(each, each.values)
            for each in self.programs
        )
        words = [f"[{', '.join(programs)}]", f"{self.stage!r}", f"{self.out.name!r}"]
        left_out = ("programs", "stage", "out", "command", "join", "constants")
        names = [name for name in type(self).__dataclass_fields__ if name not in left_out]
        # These are always written: the default backend depends on the installation.
        options = chosen(self, names, always=("seed", "actions", "backend"))
        if self.constants:
            options["constants"] = dict(self.constants)
        return call_text("explore", words, options)


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
