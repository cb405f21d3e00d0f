"""``cb explore --thing``: exploration of stable pairs of objects by actions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING

from cbdsl.api.requests.explore_pairs_request import ExplorePairsRequest
from cbdsl.cli.episodes.simulation import needing_simulation, simulation
from cbdsl.cli.output.exploration_progress import ExplorationProgress
from cbdsl.cli.output.terminal import print_line
from cbdsl.cli.process.native_output import shown_on_failure
from cbdsl.cli.process.termination import termination_interrupts
from cbdsl.diagnostics.errors import UsageError

if TYPE_CHECKING:
    import typer

    from cbdsl.api.requests.explore_request import ExploreRequest
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.training.exploration.pair_task import PairTask

# Options that apply only to the actions of a single object.
_OF_ONE = (
    "feature", "between", "algorithm", "join", "live", "live_port", "live_wait", "live_close",
    "fast",
)  # fmt: skip


def explore_pairs(
    context: typer.Context,
    given: ExploreRequest,
    thing: Sequence[str],
    relation: str,
    relations: str | None,
    *,
    as_json: bool,
) -> None:
    """Explore pairs with the options of ``cb explore``.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An option cannot be used.
    """
    _refuse_options_of_one(context)
    if len(given.programs) != 1:
        raise UsageError("--thing: one PROGRAM brings things to each other")
    shared = {each.name for each in fields(given)} & {
        each.name for each in fields(ExplorePairsRequest)
    }
    pairs = ExplorePairsRequest(
        program=str(given.programs[0]),
        things=_read_things(thing),
        relation=relation,
        relations=relations,
        **{name: getattr(given, name) for name in shared},
    )
    with needing_simulation():
        request, task = pairs.task()
        task.require_ready(resume=given.resume)
    with shown_on_failure(), termination_interrupts():
        _run(task, request, given.cameras, as_json=as_json)


def _read_things(texts: Sequence[str]) -> dict[str, str]:
    """Return the channels of objects by name, from ``NAME=CHANNEL`` or ``PAIR=@META_CATALOG``.

    Raises:
        UsageError: A text has another form, or a name occurs twice.
    """
    things: dict[str, str] = {}
    for text in texts:
        name, _, channel = text.partition("=")
        if not name or not channel:
            raise UsageError(f"--thing {text}: a thing is NAME=CHANNEL, such as ball=red")
        if name in things:
            raise UsageError(f"--thing {text}: '{name}' is there twice")
        things[name] = channel
    return things


def _refuse_options_of_one(context: typer.Context) -> None:
    for parameter in context.command.params:
        name = str(parameter.name)
        if name in _OF_ONE and context.params[name] != parameter.default:
            raise UsageError(f"{parameter.opts[0]} means nothing with --thing")


def _run(task: PairTask, request: RunRequest, cameras: str | None, *, as_json: bool) -> None:
    with simulation(request, task.backend, cameras=cameras) as (body, kinematics):
        progress = ExplorationProgress(task.count, as_json=as_json, looks_ahead=False)
        document = task.run(body, kinematics, progress)
    if not as_json:
        from cbdsl.reporting.text.meta_catalog_text import meta_catalog_text

        print(meta_catalog_text(document), end="")
        print_line(f"wrote {task.path}")
