"""A runner without a robot, in which SEARCHTRACK is a Markov decision process; and trials in it."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.checking.knowledge.program_digest import program_digest
from cbdsl.checking.program import check_program
from cbdsl.documents.policy import Provenance
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.experience import Experience
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.policies.policy import Policy
from cbdsl.training.provenance import TrialSetting, provenance_of
from cbdsl.training.task_observer import TaskObserver
from cbdsl.training.trial import Trial
from cbdsl.training.trial_work import open_journal, require_ready, run_trial
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[2]

#: Of a trial in tests.
EPISODES = 12


class ToyEpisodeRunner:
    """Something is in view in half of the episodes; else a search finds it now and then."""

    def __init__(self) -> None:
        #: The programs of all episodes, with the models that they drew from.
        self.programs: list[CheckedProgram] = []

    def run(
        self,
        program: CheckedProgram,
        policy: Policy,
        seed: int,
        see: Callable[[Transition], None],
    ) -> Experience:
        self.programs.append(program)
        rng = np.random.default_rng(seed)
        shown = bool(rng.random() < 0.5)
        in_view, state, transitions = shown, "XX", []
        rewarded: dict[str, tuple[float, ...]] = {}
        while not rewarded and len(transitions) < program.transitions:
            action = policy.choose(state, changed=True).action
            assert action is not None
            if "search" in action:
                in_view = in_view or bool(rng.random() < 0.3)
            after = _after(state, action, in_view)
            earned = ("track",) if after[1] == "1" else ()
            time = 0.1 * len(transitions)
            step = Transition("searchtrack", 0, time, state, action, after, 6, len(earned), earned)
            transitions.append(step)
            see(step)
            if earned:
                rewarded["head"] = tuple(rng.normal((0.0, 0.3) if shown else (1.3, 0.2), 0.05))
            state = after
        context = "presented" if shown else "window"
        ticks = 6 * len(transitions)
        return Experience(context, seed, tuple(transitions), rewarded, ticks, ticks / 60)


def _after(state: str, action: str, in_view: bool) -> str:
    search = "0" if "search" in action else "X"
    if "track" not in action:
        return f"{search}X" if state[0] != "0" else "1X"
    if not in_view:
        return f"{search}-"
    return f"{search}1" if state[1] == "0" else f"{search}0"


def toy_trial(seed: int = 1) -> Trial:
    return Trial(check_program("searchtrack", {}, Library(ROOT)), AccommodateConstants(), seed)


def toy_provenance(trial: Trial, episodes: int) -> Provenance:
    library = Library(ROOT)
    program, robot, stage = (
        library.locate(kind, name)
        for kind, name in (
            (ProgramDocument, "searchtrack"),
            (RobotDocument, "dexter"),
            (StageDocument, "searchtrack_training"),
        )
    )
    setting = TrialSetting(
        program_digest(program, library),
        library.read(robot, RobotDocument).document,
        library.read(stage, StageDocument).document,
        "toy",
        "none",
    )
    return provenance_of(trial, setting, episodes, "cb learn searchtrack")


def take(out: Path, episodes: int, *, resume: bool = False, seed: int = 1) -> Trial:
    """Run a trial in the toy runner."""
    trial = toy_trial(seed)
    provenance = toy_provenance(trial, episodes)
    require_ready(out, ["head"], resume=resume)
    with open_journal(out, provenance) as journal:
        run_trial(trial, ToyEpisodeRunner(), journal, provenance, out, TaskObserver())
    return trial


def take_and_die(out: Path, episodes: int, owner: object, name: str, count: int) -> None:
    """Run a trial, and kill this process when it calls a function for the ``count``th time.

    Args:
        out: File of the trial.
        episodes: Number of episodes.
        owner: Owner of the function, such as a class or a module.
        name: Name of the function.
        count: Number of the last call.
    """
    function, left = getattr(owner, name), [count]

    def deadly(*arguments: Any, **named: Any) -> Any:
        left[0] -= 1
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        return function(*arguments, **named)

    setattr(owner, name, deadly)
    take(out, episodes, resume=True)
