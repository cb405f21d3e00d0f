"""``cb explore``: exploration of an object's affordances by actions."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.api.requests.explore_request import ExploreRequest
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.command_text import option_words
from cbdsl.cli.arguments.option_groups import grouped
from cbdsl.cli.arguments.options import Cameras, Resume, Seed, Set
from cbdsl.cli.episodes.live import LiveOptions, live_page
from cbdsl.cli.episodes.simulation import BackendName, needing_simulation, simulation
from cbdsl.cli.output.terminal import print_line
from cbdsl.cli.process.native_output import shown_on_failure
from cbdsl.cli.process.termination import termination_interrupts
from cbdsl.diagnostics.errors import UsageError
from cbdsl.reporting.text.catalog_text import catalog_text

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.training.exploration.exploration_task import ExplorationTask

# Parameters that are not options of the recorded command. The programs are arguments, the number
# of actions is written last, and the others do not affect the result.
_NEVER = (
    "programs", "actions", "resume", "as_json", "live", "live_port", "live_wait", "live_close",
    "fast",
)  # fmt: skip

Programs = Annotated[
    list[str],
    typer.Argument(
        metavar="PROGRAM",
        help="Actions: programs, as NAME, NAME:key=value, or LABEL=NAME:key=value. The value ? "
        "stands for each channel that the run detects.",
    ),
]
Stage = Annotated[str, typer.Option("--stage", help="Stage with a persistent world: file or name.")]
Out = Annotated[Path, typer.Option("--out", help="File for the catalog, NAME.yaml.")]
Feature = Annotated[
    str,
    typer.Option(
        "--feature", help="Channel of the object, for all programs with the parameter feature."
    ),
]
Actions = Annotated[int, typer.Option("--actions", min=1, help="Number of actions.")]
UntilHabituated = Annotated[
    bool,
    typer.Option("--until-habituated", help="End when all models have habituated."),
]
Between = Annotated[
    str,
    typer.Option(
        "--between", help="Program that runs after each action, such as to release the object."
    ),
]
Algorithm = Annotated[
    str,
    typer.Option(
        "--algorithm",
        help="Algorithm: explore_catalog (Algorithm 3) or explore_models (Section 6.3).",
    ),
]
Thing = Annotated[
    list[str],
    typer.Option(
        "--thing",
        metavar="NAME=CHANNEL",
        help="Object and its channel. With two or more, explore the pairs that the one PROGRAM can"
        " bring together, and write a meta-catalog. PAIR=@META_CATALOG is a known stack, which is"
        " one object. May be repeated.",
    ),
]
Relation = Annotated[
    str, typer.Option("--relation", help="With --thing: relation that PROGRAM produces, on or in.")
]
Relations = Annotated[
    str | None,
    typer.Option(
        "--relations",
        metavar="FILE|NAME",
        help="With --thing: relations that name the contacts whose impedance PROGRAM tests.",
    ),
]
Join = Annotated[
    bool,
    typer.Option("--join", help="Continue with additional programs, or with a changed --stage."),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object per action.")]


@dataclass(frozen=True, kw_only=True)
class ExplorationOptions:
    """Options that are fields of the request to explore."""

    stage: Stage
    feature: Feature = "sat_10"
    actions: Actions = 100
    until_habituated: UntilHabituated = False
    seed: Seed = 0
    backend: BackendName
    cameras: Cameras = None
    between: Between = "let_go"
    algorithm: Algorithm = "explore_catalog"


@dataclass(frozen=True, kw_only=True)
class PairOptions:
    """Options of pairs of objects, which ``explore_pairs`` reads."""

    thing: Thing = field(default_factory=list)
    relation: Relation = "on"
    relations: Relations = None


@grouped
def explore(
    context: typer.Context,
    programs: Programs,
    out: Out,
    *,
    exploration: ExplorationOptions,
    pairs: PairOptions,
    set_: Set = [],  # noqa: B006 (typer)
    resume: Resume = False,
    join: Join = False,
    as_json: Json = False,
    live: LiveOptions,
) -> None:
    """Explore the affordances of an object until its models have habituated (Chapter 6).

    Rewarded actions update the models of their features; actions with the largest changes have the
    highest value. The catalog of --out holds the rewards of each action and their features. Beside
    it, the journal .actions.jsonl has a line for each finished action; --resume continues an
    interrupted exploration in a new world. With --thing, objects are brought to each other, and
    --out is a meta-catalog. It holds the impedance of each pair if the program tests it.

    Exit 0 if all actions were taken, 1 if a document has errors, 2 if an action cannot run, and 130
    after Ctrl-C or SIGTERM.
    """
    if out.suffix != ".yaml":
        raise UsageError(f"--out {out}: a catalog is <name>.yaml")
    live.require_page()
    if pairs.thing:
        from cbdsl.cli.explore_pairs import explore_pairs

        explore_pairs(context, _command(context))
        return
    request = ExploreRequest(
        programs=programs,
        out=out,
        **vars(exploration),
        constants=read_assignments(set_, "--set"),
        join=join,
        command=_command(context),
    )
    with needing_simulation():
        run, task = request.task()
        task.require_ready(resume=resume or join)
    with shown_on_failure(), termination_interrupts():
        _run(task, run, live, as_json=as_json)


def _run(task: ExplorationTask, request: RunRequest, live: LiveOptions, *, as_json: bool) -> None:
    from cbdsl.cli.output.exploration_progress import ExplorationProgress
    from cbdsl.reporting.live.exploration_view import ExplorationView

    with (
        simulation(request, task.backend, cameras=task.cameras) as (body, kinematics),
        live_page(live, request, body, prints=not as_json) as page,
    ):
        progress = ExplorationProgress(task.count, as_json=as_json)
        name, feature = task.path.stem, task.feature
        view = None if page is None else ExplorationView(page, name, feature, task.count)
        document = task.run(body, kinematics, progress, view)
        if not as_json:
            print(catalog_text(document), end="")
            print_line(f"wrote {task.path}")


def _command(context: typer.Context) -> str:
    """Return the command that repeats the exploration, in a canonical spelling."""
    programs, actions = context.params["programs"], str(context.params["actions"])
    # Folders differ between computers. The recorded command keeps the name of the file alone.
    out = {"out": ["--out", context.params["out"].name]}
    # The default backend depends on the installed packages, so that it is always written.
    options = option_words(context, _NEVER, ("seed", "backend"), out)
    return shlex.join(["cb", "explore", *programs, *options, "--actions", actions])
