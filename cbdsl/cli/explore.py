"""``cb explore``: exploration of an object's affordances by actions."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.api.requests.explore_request import ExploreRequest
from cbdsl.cli.arguments.command_text import command_text
from cbdsl.cli.arguments.option_groups import grouped
from cbdsl.cli.episodes.live import LiveOptions, live_page
from cbdsl.cli.episodes.simulation import needing_simulation, simulation
from cbdsl.cli.output.terminal import print_line
from cbdsl.cli.process.native_output import shown_on_failure
from cbdsl.cli.process.termination import termination_interrupts
from cbdsl.reporting.text.catalog_text import catalog_text

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.training.exploration.exploration_task import ExplorationTask

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
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object per action.")]


@dataclass(frozen=True, kw_only=True)
class PairOptions:
    """Options of pairs of objects, which apply only to an ``ExplorePairsRequest``."""

    thing: Thing = field(default_factory=list)
    relation: Relation = "on"
    relations: Relations = None


@grouped
def explore(
    context: typer.Context,
    *,
    request: ExploreRequest,
    pairs: PairOptions,
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
    live.require_page()
    request = replace(request, command=_command(context))
    if pairs.thing:
        from cbdsl.cli.explore_pairs import explore_pairs

        explore_pairs(context, request, as_json=as_json, **vars(pairs))
        return
    with needing_simulation():
        run, task = request.task()
        task.require_ready(resume=request.resume or request.join)
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
    # The number of actions comes last, where a longer exploration changes it.
    words = ["cb", "explore", *context.params["programs"]]
    name, also = context.params["out"].name, ("thing", "relation", "relations")
    text = command_text(context, words, ExploreRequest, name, also=also, instead={"actions": ()})
    return f"{text} --actions {context.params['actions']}"
