"""``cb learn``: learning of a program's policy from episodes."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.api.requests.learn_request import LearnRequest
from cbdsl.api.requests.load_request import LoadOptions
from cbdsl.checking.rules.reward import check_rewarded
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.command_text import command_text
from cbdsl.cli.arguments.completion import names_of
from cbdsl.cli.arguments.option_groups import grouped
from cbdsl.cli.arguments.options import Robot, With
from cbdsl.cli.arguments.workers import require_workers, warn_of_open_scheduler
from cbdsl.cli.episodes.live import LiveOptions
from cbdsl.cli.episodes.simulation import needing_simulation
from cbdsl.cli.learning_tasks import one_by_one, side_by_side
from cbdsl.cli.output.terminal import print_diagnostics, print_line
from cbdsl.cli.process.native_output import shown_on_failure
from cbdsl.cli.process.termination import termination_interrupts
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.reason import reason
from cbdsl.documents.json_schema import docstrings
from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.experience import EPISODES
from cbdsl.learning.learner import NAME_RELATIONS
from cbdsl.storage.journal_follower import JournalFollower

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.documents.document import Section
    from cbdsl.training.learning_task import LearningTask

Stage = Annotated[
    str | None,
    typer.Option(
        "--stage",
        help="Training stage: file or name [the program's].",
        autocompletion=names_of("stage"),
    ),
]
Workers = Annotated[
    int,
    typer.Option(
        "--workers", min=1, help="Number of parallel processes; the result does not depend on it."
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        help="Address of a Dask cluster, such as tcp://host:8786; its workers need access to the "
        "same files.",
    ),
]


# Typer derives options from the signature of a command. The constants are declared once, in
# `AccommodateConstants`, with their defaults and descriptions. Here they become keyword parameters,
# and their values arrive in `**spelled`, which typer itself cannot convert and which is left out.
# All are texts with units, so that `read_constants` checks them in the same way as `--set`.
# Annotations are evaluated, because this module postpones them.
def with_constants(command: Callable[..., None]) -> Callable[..., None]:
    """Command with an option for each constant of ACCOMMODATE, before ``transitions``."""
    signature = inspect.signature(command, eval_str=True)
    *given, _ = signature.parameters.values()
    place = next(i for i, each in enumerate(given) if each.name == "transitions")
    words = docstrings(AccommodateConstants)
    options = [
        inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=None,
            annotation=Annotated[
                str | None,
                typer.Option(
                    f"--{name.replace('_', '-')}",
                    help=_help(words[name], field.default),
                    rich_help_panel="Constants of accommodate",
                ),
            ],
        )
        for name, field in AccommodateConstants.model_fields.items()
    ]
    parameters = [*given[:place], *options, *given[place:]]
    command.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return command


def _help(words: str, default: object) -> str:
    return words if default is None else f"{words.rstrip('.')} [{default}]."


@dataclass(frozen=True, kw_only=True)
class TrialOptions:
    """Stage and robot of the trials, and parameters of the program."""

    stage: Stage = None
    robot: Robot = None
    with_: With = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class ProcessOptions:
    """Processes of the trials, and continuation of earlier ones."""

    workers: Workers = 1
    scheduler: Scheduler = None

    def require_suitable(self, live: LiveOptions) -> None:
        """Check the processes, and that shown episodes run in this one.

        Raises:
            UsageError: The options exclude each other.
        """
        _require_one_place(self.workers, self.scheduler)
        live.require_page()
        if live.live:
            _require_here(self.workers, self.scheduler)
        require_workers(self.workers)
        if self.scheduler is not None:
            warn_of_open_scheduler(self.scheduler)


@with_constants
@grouped
def learn(
    context: typer.Context,
    *,
    trial: TrialOptions,
    place: ProcessOptions,
    request: LearnRequest,
    live: LiveOptions,
    **spelled: str | None,
) -> None:
    """Learn the values of a program's actions from scratch, by discovering affordances.

    With --from, another robot's policy is kept, and allocations and internal models are learned.

    cb run --policy runs the policy of --out. Beside it, the journal .episodes.jsonl has a line for
    each finished episode. --resume continues an interrupted trial, with the same result as without
    the interruption.

    Exit 0 if all episodes were run, 1 if a document has errors, 2 if the program cannot run, and
    130 after Ctrl-C or SIGTERM.
    """
    place.require_suitable(live)
    values = read_assignments(trial.with_, robot=trial.robot)
    run = LoadOptions(stage=trial.stage, values=values).read(str(request.program))
    constants = {name: value for name, value in spelled.items() if value is not None}
    request = replace(request, program=run, constants={**request.constants, **constants})
    request.require_sound()
    if request.algorithm != NAME_RELATIONS:
        _tell_of_no_reward(run)
    with needing_simulation():
        # The recorded command contains the checked constants, and is therefore added to a complete
        # request.
        command = _command(context, request.checked_constants())
        tasks = replace(request, command=command).tasks()
        _require_ready(tasks, request.resume)
    at_once = min(place.workers, request.trials)  # each episode needs the previous results
    with shown_on_failure(), termination_interrupts():
        if at_once == 1 and place.scheduler is None:
            one_by_one(tasks, run, live)
        else:
            side_by_side(tasks, at_once, place.scheduler)


def _tell_of_no_reward(request: RunRequest) -> None:
    """Warn before the episodes, not after, that nothing can be learned from them."""
    diagnostics = check_rewarded(request.program, request.program_file, request.library)
    if diagnostics:
        print_diagnostics(diagnostics)


def _require_one_place(workers: int, scheduler: str | None) -> None:
    if workers > 1 and scheduler is not None:
        raise UsageError("--workers are processes of this machine, --scheduler has its own: choose")


def _require_here(workers: int, scheduler: str | None) -> None:
    """Check that episodes run where they can be shown."""
    if workers > 1 or scheduler is not None:
        option = "--scheduler" if scheduler is not None else f"--workers {workers}"
        raise UsageError(f"--live shows episodes of this process, {option} runs them in others")


def _command(context: typer.Context, constants: Section) -> str:
    """Return the command that repeats the learning, in a canonical spelling."""
    # Constants have two spellings, `--epsilon 0.1` and `--set epsilon=0.1`. The record has one.
    words = ["cb", "learn", context.params["program"]]
    return command_text(
        context,
        words,
        LearnRequest,
        context.params["out"].name,
        also=("stage", "robot", "with_"),
        instead={"constants": [*_set(constants)]},
    )


def _set(constants: Section) -> Iterator[str]:
    """Yield the options of the constants that differ from their declared values."""
    for name, declared in type(constants).model_fields.items():
        value = getattr(constants, name)
        if value != declared.default:
            has_option = name in AccommodateConstants.model_fields
            flag = f"--{name.replace('_', '-')}"
            yield from (flag, str(value)) if has_option else ("--set", f"{name}={value}")


def _require_ready(tasks: Sequence[LearningTask], resume: bool) -> None:
    """Check before the episodes, not after, that everything can be written."""
    for task in tasks:
        try:
            task.require_ready(resume=resume)
        except OSError as error:
            where = f" ({error.filename})" if error.filename else ""
            problem = f"--out {task.path}: {reason(error)}{where}"
            raise UsageError(problem) from error
    if resume:
        _tell_what_is_there(tasks)


def _tell_what_is_there(tasks: Sequence[LearningTask]) -> None:
    """Report journals that are missing or hold more episodes than asked for."""
    begun = [each for each in tasks if each.journal.exists()]
    if not begun:
        print_line(f"nothing to go on with: {tasks[0].journal} is not there; begins anew")
    for task in begun:
        there = len(JournalFollower(task.journal, EPISODES).poll())
        if there > task.episodes:
            first = f"the first {task.episodes} of its {there} episodes"
            print_line(f"{task.journal}: {first} count, all are kept")
