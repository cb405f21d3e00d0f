"""``cb explore --thing``: exploration of stable pairs of objects by actions."""

from __future__ import annotations

from typing import TYPE_CHECKING, get_args

from cbdsl.cli.assignments import read_assignments
from cbdsl.cli.explored_pairs import read_pairs, read_things
from cbdsl.cli.native_output import shown_on_failure
from cbdsl.cli.simulation import needing_simulation, simulation
from cbdsl.cli.termination import termination_interrupts
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.meta_catalog import Relation

if TYPE_CHECKING:
    import typer

    from cbdsl.api.run_request import RunRequest
    from cbdsl.training.pair_task import PairTask


# Options that apply only to the actions of a single object.
_OF_ONE = (
    "feature", "between", "algorithm", "join", "live", "live_port", "live_wait", "live_close",
    "fast",
)  # fmt: skip


def explore_pairs(context: typer.Context, command: str) -> None:
    """Explore pairs with the options of ``cb explore``.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An option cannot be used.
    """
    given = context.params
    _refuse_options_of_one(context)
    if given["relation"] not in get_args(Relation):
        raise UsageError.unknown("relation", given["relation"], get_args(Relation))
    if len(given["programs"]) != 1:
        raise UsageError("--thing: one PROGRAM brings things to each other")
    things = read_things(given["thing"])
    with needing_simulation():
        from cbdsl.learning.catalog_exploration import CatalogConstants
        from cbdsl.learning.constants import read_constants
        from cbdsl.training.pair_task import PairTask

        request, pairs = read_pairs(given["programs"][0], things, given["relation"], given["stage"])
        constants = read_constants(
            CatalogConstants, read_assignments(given["set_"], "--set"), "explore_pairs"
        )
        assert isinstance(constants, CatalogConstants)
        task = PairTask(
            pairs=pairs,
            things=things,
            relation=given["relation"],
            robot=request.robot,
            stage=request.stage,
            backend=given["backend"],
            constants=constants,
            seed=given["seed"],
            count=given["actions"],
            until_habituated=given["until_habituated"],
            command=command,
            path=given["out"].absolute(),
        )
        task.require_ready(resume=given["resume"])
    with shown_on_failure(), termination_interrupts():
        _run(task, request, given["cameras"], as_json=given["as_json"])


def _refuse_options_of_one(context: typer.Context) -> None:
    for parameter in context.command.params:
        name = str(parameter.name)
        if name in _OF_ONE and context.params[name] != parameter.default:
            raise UsageError(f"{parameter.opts[0]} means nothing with --thing")


def _run(task: PairTask, request: RunRequest, cameras: str | None, *, as_json: bool) -> None:
    from cbdsl.cli.exploration_progress import ExplorationProgress

    with simulation(request, task.backend, cameras=cameras) as (body, kinematics):
        progress = ExplorationProgress(task.count, as_json=as_json, looks_ahead=False)
        document = task.run(body, kinematics, progress)
    if not as_json:
        from cbdsl.reporting.text.meta_catalog_text import meta_catalog_text

        print(meta_catalog_text(document), end="")
        print(f"wrote {task.path}")
