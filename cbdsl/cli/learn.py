"""``cb learn``: teach a program what to do, from episodes that are run."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from cbdsl.backends.backend import Backend
    from cbdsl.cli.order import Order
    from cbdsl.documents.policy import Provenance
    from cbdsl.learning.accommodate import Constants
    from cbdsl.learning.prior import Form
    from cbdsl.program.checked import CheckedProgram
    from cbdsl.robot.kinematics import Kinematics
    from cbdsl.training.classroom import Classroom
    from cbdsl.training.trial import Trial

# What a command names even where it is the default: they say how much was done, and by what chance.
_ALWAYS = ("episodes", "seed", "backend")

Program = Annotated[str, typer.Argument(help="A program: its file, or its name.")]
Out = Annotated[
    Path, typer.Option("--out", help="File for the policy; internal models go beside it.")
]
Stage = Annotated[
    str | None,
    typer.Option("--stage", help="Training context: a file or a name [the program's own]."),
]
Episodes = Annotated[int, typer.Option("--episodes", min=1, help="How many episodes in all.")]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of all chance.")]
BackendName = Annotated[str, typer.Option("--backend", help="What embodies the robot.")]
With = Annotated[
    list[str],
    typer.Option("--with", help="A parameter of the program, as arm=left_arm; may be repeated."),
]
Resume = Annotated[
    bool, typer.Option("--resume", help="Go on where a trial was interrupted, or make it longer.")
]
Sequential = Annotated[
    bool, typer.Option("--sequential", help="Leave out the actions that are compositions.")
]
Gamma = Annotated[float, typer.Option("--gamma", min=0, max=0.999999, help="Discount.")]
Alpha = Annotated[float, typer.Option("--alpha", min=1e-6, max=1, help="Learning rate.")]
Epsilon = Annotated[
    float, typer.Option("--epsilon", min=0, max=1, help="Share of actions chosen at random.")
]
Density = Annotated[
    str, typer.Option("--density", help="Form of the internal models: kernel or gaussian.")
]
Bandwidth = Annotated[
    float, typer.Option("--bandwidth", min=1e-6, help="Width of their kernels, rad.")
]
Prior = Annotated[
    float,
    typer.Option("--prior", min=0, help="As how many samples the uniform density counts in them."),
]
Transitions = Annotated[
    int | None,
    typer.Option("--transitions", min=1, help="Most transitions of an episode [the program's]."),
]
TransitionTime = Annotated[
    float | None,
    typer.Option("--transition-time", min=0.1, help="Its longest action, s [the program's]."),
]


def learn(
    context: typer.Context,
    program: Program,
    out: Out,
    stage: Stage = None,
    episodes: Episodes = 50,
    seed: Seed = 0,
    backend: BackendName = "bullet",
    with_: With = [],  # noqa: B006 (typer)
    resume: Resume = False,
    sequential: Sequential = False,
    gamma: Gamma = 0.8,
    alpha: Alpha = 0.1,
    epsilon: Epsilon = 0.2,
    density: Density = "kernel",
    bandwidth: Bandwidth = 0.1,
    prior: Prior = 10.0,
    transitions: Transitions = None,
    transition_time: TransitionTime = None,
) -> None:
    """Learn what a program's actions are good for, from zero, by discovering affordances.

    The policy in --out runs with cb run --policy. Beside it, a file that ends in .episodes.jsonl
    holds each episode as soon as it is over: an interrupted trial goes on with --resume, and ends
    as if it had never been interrupted.

    Exit 0 when all episodes were run, 1 when a document has errors, 2 when it could not run.
    """
    from cbdsl.cli.assignments import read_assignments
    from cbdsl.cli.order import read_order
    from cbdsl.cli.quiet import shown_on_failure
    from cbdsl.cli.simulation import simulation
    from cbdsl.training.trial import Trial

    _require_name(out)
    order = read_order(program, stage, None, read_assignments(with_))
    constants = _constants(gamma, alpha, epsilon, density, bandwidth, prior)
    with shown_on_failure(), simulation(order, backend) as (body, kinematics):
        lesson = _lesson(order.program, sequential, transitions, transition_time)
        trial = Trial(lesson, constants, seed)
        provenance = _provenance(trial, order, body, backend, episodes, _command(context))
        _follow(trial, _classroom(order, kinematics, body), provenance, out, resume=resume)


def _require_name(out: Path) -> None:
    """Find out before the episodes, not after, whether --out can hold a policy."""
    from cbdsl.documents.document import NAME_PATTERN
    from cbdsl.errors.errors import UsageError

    if out.suffix != ".yaml" or not re.match(NAME_PATTERN, out.stem):
        raise UsageError(f"--out {out}: a policy is <name>.yaml, of letters, digits and _")
    if out.is_dir():
        raise UsageError(f"--out {out}: is a folder")


def _constants(
    gamma: float, alpha: float, epsilon: float, density: str, bandwidth: float, prior: float
) -> Constants:
    from cbdsl.errors.errors import UsageError
    from cbdsl.learning.accommodate import Constants

    if density not in ("kernel", "gaussian"):
        raise UsageError(f"--density {density}: it is kernel or gaussian")
    form: Form = "kernel" if density == "kernel" else "gaussian"
    return Constants(gamma, alpha, epsilon, form, bandwidth, prior)


def _lesson(
    program: CheckedProgram,
    sequential: bool,
    transitions: int | None,
    transition_time: float | None,
) -> CheckedProgram:
    """The program with the actions and limits of the trial."""
    single = tuple(action for action in program.actions if action.name in program.members)
    return program._replace(
        actions=single if sequential else program.actions,
        transitions=transitions or program.transitions,
        transition_time=transition_time or program.transition_time,
    )


def _command(context: typer.Context) -> str:
    """What learns the same again, in one spelling, however it was typed."""
    given = context.params | {"out": context.params["out"].name, "resume": False}
    words = ["cb", "learn", given["program"]]
    for parameter in context.command.params:
        name, value = str(parameter.name), given[str(parameter.name)]
        if name == "program" or (value == parameter.default and name not in _ALWAYS):
            continue
        flag = parameter.opts[0]
        several = value if isinstance(value, (list, tuple)) else [value]
        words += [flag] if value is True else [w for each in several for w in (flag, str(each))]
    return shlex.join(words)


def _provenance(
    trial: Trial, order: Order, body: Backend, backend: str, episodes: int, command: str
) -> Provenance:
    from cbdsl.checking.digest import program_digest
    from cbdsl.training.provenance import Setting, provenance_of

    setting = Setting(
        program_sha256=program_digest(order.program_file, order.library),
        robot=order.robot,
        stage=order.stage,
        backend=backend,
        renderer=body.renderer,
    )
    return provenance_of(trial, setting, episodes, command)


def _classroom(order: Order, kinematics: Kinematics, body: Backend) -> Classroom:
    from cbdsl.training.classroom import BackendClassroom

    return BackendClassroom(order.robot, kinematics, body, order.stage)


def _follow(
    trial: Trial, classroom: Classroom, provenance: Provenance, out: Path, *, resume: bool
) -> None:
    from cbdsl.cli.learning_progress import LearningProgress
    from cbdsl.cli.terminal import print_problem
    from cbdsl.errors.errors import UsageError
    from cbdsl.robot.signals import SensorError
    from cbdsl.training.course import follow, journal_file, open_journal

    try:
        with (
            open_journal(out, provenance, resume=resume) as journal,
            LearningProgress(provenance, len(journal.finished)) as progress,
        ):
            files = follow(trial, classroom, journal, provenance, out, progress.note)
    except SensorError as error:
        raise UsageError(f"episode {len(trial.experiences) + 1}: {error}") from error
    except OSError as error:
        told = error.strerror or error
        kept = f"; {journal_file(out)} holds what was run, --resume goes on with it"
        raise UsageError(f"--out {out}: {told}{kept if trial.experiences else ''}") from error
    except KeyboardInterrupt:
        print_problem(f"interrupted after {len(trial.experiences)} episodes; --resume goes on")
        raise
    for file in files:
        print(f"wrote {file}")
