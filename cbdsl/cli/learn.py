"""``cb learn``: learning of a program's policy from episodes."""

from __future__ import annotations

import inspect
import shlex
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.api.requests.learn_request import LearnRequest
from cbdsl.api.requests.run_request import read_request
from cbdsl.checking.rules.reward import check_rewarded
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.command_text import option_words
from cbdsl.cli.arguments.completion import names_of
from cbdsl.cli.arguments.option_groups import grouped
from cbdsl.cli.arguments.options import Cameras, Program, Resume, Seed, Set, With
from cbdsl.cli.arguments.workers import require_workers, warn_of_open_scheduler
from cbdsl.cli.episodes.live import LiveOptions
from cbdsl.cli.episodes.simulation import BackendName, needing_simulation
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

# Options that the recorded command includes even with default values.
_ALWAYS = ("episodes", "seed", "backend")
# Parameters that are not options of the recorded command. The program is an argument, the constants
# are written by _set, and the others do not affect the result.
_NEVER = (
    "program", "resume", "workers", "scheduler", "live", "live_port", "live_wait", "live_close",
    "fast", *AccommodateConstants.model_fields,
)  # fmt: skip

Out = Annotated[
    Path,
    typer.Option(
        "--out", help="File for the policy, NAME.yaml; internal models are written beside it."
    ),
]
Stage = Annotated[
    str | None,
    typer.Option(
        "--stage",
        help="Training stage: file or name [the program's].",
        autocompletion=names_of("stage"),
    ),
]
Episodes = Annotated[int, typer.Option("--episodes", min=1, help="Total number of episodes.")]
Trials = Annotated[
    int,
    typer.Option(
        "--trials",
        min=1,
        max=10_000,
        help="Number of trials, each from scratch: NAME_0.yaml, NAME_1.yaml, ...",
    ),
]
Workers = Annotated[
    int,
    typer.Option(
        "--workers",
        min=1,
        help="Number of parallel processes; the result does not depend on it.",
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
Sequential = Annotated[
    bool, typer.Option("--sequential", help="Leave out actions that are compositions.")
]
LearnerName = Annotated[str, typer.Option("--learner", help="Learner; cb show learners lists all.")]
From = Annotated[
    str | None,
    typer.Option(
        "--from",
        help="With assimilate: learned policy of the schema; with name_relations: relations to go "
        "on from. File or name.",
    ),
]
Transitions = Annotated[
    int | None,
    typer.Option(
        "--transitions", min=1, help="Maximum number of transitions of an episode [the program's]."
    ),
]
TransitionTime = Annotated[
    float | None,
    typer.Option(
        "--transition-time",
        min=0.1,
        max=86400,
        help="Maximum time of one action without a change of state, s [the program's].",
    ),
]
IdleTime = Annotated[
    float | None,
    typer.Option(
        "--idle-time",
        min=0.1,
        max=86400,
        help="The same while no predicate is 0, s [the program's].",
    ),
]
EpisodeTime = Annotated[
    float | None,
    typer.Option(
        "--episode-time",
        min=0.1,
        max=86400,
        help="Maximum time of an episode, s, including the programs that it uses [the program's].",
    ),
]


# Typer derives options from the signature of a command. The constants are declared once, in
# `AccommodateConstants`, with their defaults and descriptions. Here they become keyword parameters,
# and their values arrive in `**constants`, which typer itself cannot convert and which is left out.
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
    """Stage, robot and number of episodes of the trials."""

    stage: Stage = None
    episodes: Episodes = 10
    seed: Seed = 0
    backend: BackendName
    cameras: Cameras = None
    with_: With = field(default_factory=list)
    trials: Trials = 1


@dataclass(frozen=True, kw_only=True)
class ProcessOptions:
    """Processes of the trials, and continuation of earlier ones."""

    workers: Workers = 1
    scheduler: Scheduler = None
    resume: Resume = False

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


@dataclass(frozen=True, kw_only=True)
class AlgorithmOptions:
    """Algorithm with its constants and its earlier knowledge."""

    sequential: Sequential = False
    learner: LearnerName = "accommodate"
    from_: From = None
    set_: Set = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class LimitOptions:
    """Limits of an episode, which are fields of the request to learn."""

    transitions: Transitions = None
    transition_time: TransitionTime = None
    idle_time: IdleTime = None
    episode_time: EpisodeTime = None


@with_constants
@grouped
def learn(
    context: typer.Context,
    program: Program,
    out: Out,
    *,
    trial: TrialOptions,
    place: ProcessOptions,
    algorithm: AlgorithmOptions,
    limits: LimitOptions,
    live: LiveOptions,
    **constants: str | None,
) -> None:
    """Learn the values of a program's actions from scratch, by discovering affordances.

    cb run --policy runs the policy of --out. Beside it, the journal .episodes.jsonl has a line for
    each finished episode. --resume continues an interrupted trial, with the same result as without
    the interruption.

    Exit 0 if all episodes were run, 1 if a document has errors, 2 if the program cannot run, and
    130 after Ctrl-C or SIGTERM.
    """
    place.require_suitable(live)
    run = read_request(program, trial.stage, None, read_assignments(trial.with_))
    given = {name: value for name, value in constants.items() if value is not None}
    request = LearnRequest(
        run=run,
        out=out,
        episodes=trial.episodes,
        seed=trial.seed,
        trials=trial.trials,
        backend=trial.backend,
        cameras=trial.cameras,
        learner=algorithm.learner,
        constants=read_assignments(algorithm.set_, "--set") | given,
        policy=algorithm.from_,
        sequential=algorithm.sequential,
        **vars(limits),
    )
    request.require_sound()
    if request.learner != NAME_RELATIONS:
        _tell_of_no_reward(run)
    with needing_simulation():
        # The recorded command contains the checked constants, and is therefore added to a complete
        # request.
        command = _command(context, request.checked_constants())
        tasks = replace(request, command=command).tasks()
        _require_ready(tasks, place.resume)
    at_once = min(place.workers, trial.trials)  # each episode needs the previous results
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
    # Folders differ between computers. The recorded command keeps the name of the file alone.
    # Constants have two spellings, `--epsilon 0.1` and `--set epsilon=0.1`. The record has one.
    instead = {"out": ["--out", context.params["out"].name], "set_": [*_set(constants)]}
    options = option_words(context, _NEVER, _ALWAYS, instead)
    return shlex.join(["cb", "learn", context.params["program"], *options])


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
