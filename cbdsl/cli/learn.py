"""``cb learn``: teach a program what to do, from episodes that are run."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from cbdsl.cli.order import Order
    from cbdsl.learning.accommodate import Constants
    from cbdsl.learning.prior import Form
    from cbdsl.program.checked import CheckedProgram
    from cbdsl.training.assignment import Assignment

# What a command names even where it is the default: they say how much was done, and by what chance.
_ALWAYS = ("episodes", "seed", "backend")
# The program stands without an option, and how a trial gets to its end does not matter to it.
_NEVER = ("program", "resume", "workers", "scheduler")

Program = Annotated[str, typer.Argument(help="A program: its file, or its name.")]
Out = Annotated[
    Path,
    typer.Option("--out", help="File for the policy, NAME.yaml; internal models go beside it."),
]
Stage = Annotated[
    str | None,
    typer.Option("--stage", help="Training context: a file or a name [the program's own]."),
]
Episodes = Annotated[int, typer.Option("--episodes", min=1, help="How many episodes in all.")]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of all chance.")]
BackendName = Annotated[str, typer.Option("--backend", help="What embodies the robot.")]
Cameras = Annotated[
    str | None,
    typer.Option("--cameras", help="Its cameras: rendered or ideal [the backend's own]."),
]
Trials = Annotated[
    int,
    typer.Option(
        "--trials",
        min=1,
        max=10_000,
        help="How many times, each from zero: NAME_0.yaml, NAME_1.yaml, and on.",
    ),
]
Workers = Annotated[
    int,
    typer.Option(
        "--workers",
        min=1,
        help="How many trials at once, in processes of one thread; the outcome stays the same.",
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        help="Address of a Dask cluster, such as tcp://host:8786, whose workers see these files.",
    ),
]
With = Annotated[
    list[str],
    typer.Option("--with", help="A parameter of the program, as arm=left_arm; may be repeated."),
]
Resume = Annotated[
    bool, typer.Option("--resume", help="Go on where trials were interrupted, or make them longer.")
]
Sequential = Annotated[
    bool, typer.Option("--sequential", help="Leave out the actions that are compositions.")
]
Gamma = Annotated[float, typer.Option("--gamma", min=0, max=0.999999, help="Discount.")]
Alpha = Annotated[float, typer.Option("--alpha", min=1e-6, max=1, help="Learning rate.")]
Epsilon = Annotated[
    float, typer.Option("--epsilon", min=0, max=1, help="Share of actions chosen at random.")
]
ExploringEpisodes = Annotated[
    int | None,
    typer.Option(
        "--exploring-episodes",
        min=0,
        help="Episodes with --epsilon; later ones do what is best, and learn from it [all].",
    ),
]
Density = Annotated[
    str, typer.Option("--density", help="Form of the internal models: kernel or gaussian.")
]
Bandwidth = Annotated[
    float, typer.Option("--bandwidth", min=1e-6, max=100, help="Width of their kernels, rad.")
]
Prior = Annotated[
    float,
    typer.Option(
        "--prior", min=0, max=1e9, help="As how many samples the uniform density counts in them."
    ),
]
Transitions = Annotated[
    int | None,
    typer.Option("--transitions", min=1, help="Most transitions of an episode [the program's]."),
]
TransitionTime = Annotated[
    float | None,
    typer.Option(
        "--transition-time", min=0.1, max=86400, help="Its longest action, s [the program's]."
    ),
]
IdleTime = Annotated[
    float | None,
    typer.Option(
        "--idle-time",
        min=0.1,
        max=86400,
        help="Its longest action while no predicate is 0, s [the program's].",
    ),
]


def learn(
    context: typer.Context,
    program: Program,
    out: Out,
    stage: Stage = None,
    episodes: Episodes = 50,
    seed: Seed = 0,
    backend: BackendName = "bullet",
    cameras: Cameras = None,
    with_: With = [],  # noqa: B006 (typer)
    trials: Trials = 1,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    resume: Resume = False,
    sequential: Sequential = False,
    gamma: Gamma = 0.8,
    alpha: Alpha = 0.1,
    epsilon: Epsilon = 0.2,
    exploring_episodes: ExploringEpisodes = None,
    density: Density = "kernel",
    bandwidth: Bandwidth = 0.1,
    prior: Prior = 10.0,
    transitions: Transitions = None,
    transition_time: TransitionTime = None,
    idle_time: IdleTime = None,
) -> None:
    """Learn what a program's actions are good for, from zero, by discovering affordances.

    The policy in --out runs with cb run --policy. Beside it, a file that ends in .episodes.jsonl
    holds each episode as soon as it is over, one a line: whatever interrupts a trial, it goes on
    with --resume, and ends as if it had never been interrupted.

    Exit 0 when all episodes were run, 1 when a document has errors, 2 when it could not run, 130
    when it was interrupted, by Ctrl-C or SIGTERM.
    """
    from cbdsl.cli.assignments import read_assignments
    from cbdsl.cli.lessons import one_by_one, side_by_side
    from cbdsl.cli.order import read_order
    from cbdsl.cli.quiet import shown_on_failure
    from cbdsl.cli.simulation import needing_simulation
    from cbdsl.cli.termination import termination_interrupts
    from cbdsl.learning.accommodate import Constants

    _require_name(out)
    _require_one_place(workers, scheduler)
    order = read_order(program, stage, None, read_assignments(with_))
    _tell_of_no_reward(order)
    lesson = _lesson(order.program, sequential, transitions, transition_time, idle_time)
    with needing_simulation():
        constants = Constants(
            gamma=gamma,
            alpha=alpha,
            epsilon=epsilon,
            exploring_episodes=exploring_episodes,
            density=_form(density),
            bandwidth=bandwidth,
            prior=prior,
        )
        first = _assignment(order, lesson, constants, backend, seed, episodes, context, out)
        assignments = _numbered(first, trials)
        _require_ready(assignments, resume)
    at_once = min(workers, trials)  # an episode needs what the one before it taught
    with shown_on_failure(), termination_interrupts():
        if at_once == 1 and scheduler is None:
            one_by_one(assignments, order)
        else:
            side_by_side(assignments, at_once, scheduler)


def _tell_of_no_reward(order: Order) -> None:
    """Tell before the episodes, not after, that nothing can be learned from them."""
    from cbdsl.checking.reward import check_rewarded
    from cbdsl.cli.terminal import print_diagnostics

    found = check_rewarded(order.program, order.program_file, order.library)
    if found:
        print_diagnostics(found)


def _require_name(out: Path) -> None:
    """Find out before the episodes, not after, whether --out can hold a policy."""
    from cbdsl.documents.document import NAME_PATTERN
    from cbdsl.errors.errors import UsageError

    if out.suffix != ".yaml" or not re.match(NAME_PATTERN, out.stem):
        raise UsageError(f"--out {out}: a policy is <name>.yaml, of letters, digits and _")
    if out.is_dir():
        raise UsageError(f"--out {out}: is a folder")


def _require_one_place(workers: int, scheduler: str | None) -> None:
    from cbdsl.errors.errors import UsageError

    if workers > 1 and scheduler is not None:
        raise UsageError("--workers are processes of this machine, --scheduler has its own: choose")


def _form(density: str) -> Form:
    from cbdsl.errors.errors import UsageError

    if density not in ("kernel", "gaussian"):
        raise UsageError(f"--density {density}: it is kernel or gaussian")
    return "kernel" if density == "kernel" else "gaussian"


def _lesson(
    program: CheckedProgram,
    sequential: bool,
    transitions: int | None,
    transition_time: float | None,
    idle_time: float | None,
) -> CheckedProgram:
    """The program with the actions and limits of the trial."""
    return program._replace(
        actions=program.sequential_actions if sequential else program.actions,
        transitions=transitions or program.transitions,
        transition_time=transition_time or program.transition_time,
        idle_time=idle_time or program.idle_time,
    )


def _command(context: typer.Context) -> str:
    """What learns the same again, in one spelling, however it was typed."""
    given = context.params | {"out": context.params["out"].name}
    words = ["cb", "learn", given["program"]]
    for parameter in context.command.params:
        name, value = str(parameter.name), given[str(parameter.name)]
        if name in _NEVER or (value == parameter.default and name not in _ALWAYS):
            continue
        flag = parameter.opts[0]
        several = value if isinstance(value, (list, tuple)) else [value]
        words += [flag] if value is True else [w for each in several for w in (flag, str(each))]
    return shlex.join(words)


def _assignment(
    order: Order,
    lesson: CheckedProgram,
    constants: Constants,
    backend: str,
    seed: int,
    episodes: int,
    context: typer.Context,
    out: Path,
) -> Assignment:
    from cbdsl.checking.knowledge.digest import program_digest
    from cbdsl.training.assignment import Assignment

    return Assignment(
        program=lesson,
        program_sha256=program_digest(order.program_file, order.library),
        robot=order.robot,
        urdf=order.urdf.absolute(),
        stage=order.stage,
        backend=backend,
        constants=constants,
        seed=seed,
        number=0,
        episodes=episodes,
        command=_command(context),
        cameras=context.params["cameras"],
        path=out.absolute(),
    )


def _numbered(first: Assignment, trials: int) -> list[Assignment]:
    """As many trials; where they are several, their files are numbered."""
    if trials == 1:
        return [first]
    return [
        replace(first, number=n, path=first.path.with_stem(f"{first.path.stem}_{n}"))
        for n in range(trials)
    ]


def _require_ready(assignments: Sequence[Assignment], resume: bool) -> None:
    """Find out before the episodes, not after, whether everything can be kept."""
    from cbdsl.errors.errors import UsageError
    from cbdsl.errors.reason import reason

    for assignment in assignments:
        try:
            assignment.require_ready(resume=resume)
        except OSError as error:
            where = f" ({error.filename})" if error.filename else ""
            told = f"--out {assignment.path}: {reason(error)}{where}"
            raise UsageError(told) from error
    if resume:
        _tell_what_is_there(assignments)


def _tell_what_is_there(assignments: Sequence[Assignment]) -> None:
    """What of the trials to go on with is not as one may think."""
    from cbdsl.training.onlooker import Onlooker

    begun = [each for each in assignments if each.journal.exists()]
    if not begun:
        print(f"nothing to go on with: {assignments[0].journal} is not there; begins anew")
    for assignment in begun:
        there = len(Onlooker(assignment.journal).look())
        if there > assignment.episodes:
            first = f"the first {assignment.episodes} of its {there} episodes"
            print(f"{assignment.journal}: {first} count, all are kept")
