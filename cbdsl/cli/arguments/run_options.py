"""Options of a run of a program, for several commands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.api.requests.run_request import read_request
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.completion import names_of
from cbdsl.cli.arguments.options import BackendName, BodyNumber, Cameras, Policy, Rate, Robot, With
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.nearest import suggestion

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.stage import StageDocument


Stage = Annotated[
    str | None,
    typer.Option(
        "--stage", help="Stage: file or name [the program's].", autocompletion=names_of("stage")
    ),
]
Context = Annotated[
    str | None, typer.Option("--context", help="Context of the stage [drawn by share].")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of the first episode.")]
Episodes = Annotated[
    int, typer.Option("--episodes", min=1, help="Number of episodes, with successive seeds.")
]
Workers = Annotated[
    int,
    typer.Option(
        "--workers", min=1, help="Simulators: number of parallel processes, which tell endings."
    ),
]
Schema = Annotated[
    str | None,
    typer.Option(
        "--schema",
        help="Schema that chooses the resources: file or name.",
        autocompletion=names_of("schema"),
    ),
]
Calibration = Annotated[
    str | None,
    typer.Option("--calibration", help="Calibration of the cameras: file or name [the robot's]."),
]
Clearance = Annotated[
    str | None,
    typer.Option(
        "--clearance", help="Least distance between the robot's links: 2cm [the program's]."
    ),
]
Watch = Annotated[
    bool,
    typer.Option(
        "--watch", help="Simulators: take up edits of the program at its next change of state."
    ),
]
Gui = Annotated[bool, typer.Option("--gui", help="Open the simulator's window.")]


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of a run: program's inputs, episodes and robot."""

    stage: Stage = None
    context: Context = None
    seed: Seed = 0
    episodes: Episodes = 1
    workers: Workers = 1
    backend: BackendName
    cameras: Cameras = None
    rate: Rate = None
    policy: Policy = None
    schema: Schema = None
    with_: With = field(default_factory=list)
    robot: Robot = None
    calibration: Calibration = None
    body: BodyNumber = None
    gui: Gui = False
    clearance: Clearance = None
    watch: Watch = False

    def require_exclusive(self) -> None:
        """Refuse two policies, and edits of a schema.

        Raises:
            UsageError: The options name a policy and a schema, or a schema and edits.
        """
        if self.watch and self.schema is not None:
            raise UsageError("--watch takes up no edits under a schema: give --schema alone")
        if self.policy is not None and self.schema is not None:
            raise UsageError("a schema names its policy: give --policy or --schema, not both")

    def request(self, program: str, given: Mapping[Path, bytes] | None = None) -> RunRequest:
        """Return the request of a program, located, read and checked.

        Args:
            program: File or name of the program.
            given: Contents that replace those of files.

        Raises:
            DiagnosticsError: A document has errors.
            UsageError: An option is unknown or unsuitable.
        """
        request = read_request(
            program,
            self.stage,
            self.policy,
            read_assignments(self.with_, robot=self.robot),
            schema=self.schema,
            calibration=self.calibration,
            body=self.body,
            clearance=self.clearance,
            given=given,
        ).at_rate(self.rate)
        _require_context(request.stage, self.context)
        return request


def _require_context(stage: StageDocument, context: str | None) -> None:
    if context is None or context in stage.contexts:
        return
    near, known = suggestion(context, stage.contexts), ", ".join(stage.contexts)
    raise UsageError(f"stage '{stage.name}' has no context '{context}'{near} (known: {known})")
