"""Options of a run of a program, for several commands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.api.requests.load_request import LoadOptions
from cbdsl.cli.arguments.options import BackendName, Cameras
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.nearest import suggestion

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.stage import StageDocument


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
        "--workers", min=1, help="Simulators: parallel processes; only endings are printed."
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
class RunOptions(LoadOptions):
    """Options of a run: program's inputs, episodes and robot."""

    context: Context = None
    seed: Seed = 0
    episodes: Episodes = 1
    workers: Workers = 1
    backend: BackendName
    cameras: Cameras = None
    gui: Gui = False
    watch: Watch = False

    def require_exclusive(self) -> None:
        """Refuse edits of a schema.

        Raises:
            UsageError: The options name a schema and edits.
        """
        if self.watch and self.schema is not None:
            raise UsageError("--watch takes up no edits under a schema: give --schema alone")

    def request(self, program: str, given: Mapping[Path, bytes] | None = None) -> RunRequest:
        """Return the request of a program, located, read and checked.

        Args:
            program: File or name of the program.
            given: Contents that replace those of files.

        Raises:
            DiagnosticsError: A document has errors.
            UsageError: An option is unknown or unsuitable.
        """
        request = self.read(program, given)
        _require_context(request.stage, self.context)
        return request


def _require_context(stage: StageDocument, context: str | None) -> None:
    if context is None or context in stage.contexts:
        return
    near, known = suggestion(context, stage.contexts), ", ".join(stage.contexts)
    raise UsageError(f"stage '{stage.name}' has no context '{context}'{near} (known: {known})")
