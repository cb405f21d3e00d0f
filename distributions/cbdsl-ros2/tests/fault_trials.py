"""Fault trials: a program drives a served robot, and one of the two gets a fault.

``python distributions/cbdsl-ros2/tests/fault_trials.py --count 100`` runs them into
``build/faults.jsonl``; trials of this file are not repeated, and ``--seconds`` bounds the time.
``--summary`` prints a table with exact 95 % intervals. Each trial has three processes: this one,
the served robot, and the program. They are forked after all imports and compilation, so that a
trial takes seconds.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import mmap
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cbdsl.backends.drivers.link import DriverLink
from cbdsl.backends.drivers.sample import Command
from cbdsl.documents.robot import RobotDocument

ROOT = Path(__file__).parents[3]
KINDS = (
    "program killed", "program suspended", "robot killed", "robot suspended", "robot restarted",
    "stall", "loss", "clock", "swap", "missing", "double", "nan", "frozen", "effort",
    "two commanders",
    "guarded program killed", "guarded program suspended",
)  # fmt: skip
#: Faults of which a program notices nothing, or that it may survive.
HARMLESS = ("swap", "loss")
#: Longest time until the robot is still, s, and the speed of a robot that is still, rad/s.
STILL, SLOW = 0.15, 0.02
SUSPENDED = 0.6
_ROWS, _MOTION = 4000, 1.2


class Outcome(NamedTuple):
    """Outcome of a trial.

    Attributes:
        kind: Fault.
        seed: Seed of the trial.
        still: Time from the fault, or the last command after a loss, until the robot is still, s.
        moving: True if the robot moved when the fault came.
        commands: References that reached the robot.
        violations: References beyond a limit of position, velocity or acceleration, or not finite.
        cause: Last words of the program.
    """

    kind: str
    seed: int
    still: float
    moving: bool
    commands: int
    violations: int
    cause: str


def robot(*, guarded: bool = False) -> tuple[RobotDocument, Path]:
    """Return the six-axis arm, with a driver, at 60 Hz, and the path of its model.

    Args:
        guarded: True for a forward controller, which needs a watchdog.
    """
    from cbdsl.documents.driver import Driver
    from cbdsl.yaml_text.library import Library

    library = Library(ROOT)
    path = library.locate(RobotDocument, "sixaxis")
    document = library.read(path, RobotDocument).document
    driver = Driver(
        kind="ros2",
        moves=("arm",),
        states="/joint_states",
        commands="/controller/joint_trajectory",
        form="positions" if guarded else "trajectory",
    )
    control = document.control.model_copy(update={"rate": 60.0})
    changes = {"drivers": {"arm": driver}, "control": control}
    return document.model_copy(update=changes), path.parent / document.model


class Shared:
    """Rows of numbers that another process writes, for as long as it lives."""

    def __init__(self, columns: int) -> None:
        self._map = mmap.mmap(-1, 8 * (1 + _ROWS * columns))
        self._numbers = np.frombuffer(self._map, dtype=np.float64)
        self._rows = self._numbers[1:].reshape(_ROWS, columns)

    def add(self, row: np.ndarray) -> None:
        count = int(self._numbers[0])
        if count < _ROWS:
            self._rows[count] = row
            self._numbers[0] = count + 1

    @property
    def rows(self) -> np.ndarray:
        """Rows so far."""
        return self._rows[: int(self._numbers[0])].copy()


def fork(work: Callable[[], None]) -> int:
    """Run a function in a child process; return its number."""
    child = os.fork()
    if child:
        return child
    try:
        os.setpgid(0, 0)
        work()
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(0)


class Trial:
    """One trial.

    Args:
        kind: Fault.
        seed: Seed of posture, time and lost messages.
    """

    def __init__(self, kind: str, seed: int) -> None:
        self._kind, self._seed = kind, seed
        self._rng = np.random.default_rng([seed, KINDS.index(kind)])
        self._guarded = kind.startswith("guarded")
        self._robot, self._urdf = robot(guarded=self._guarded)
        joints = len(self._robot.effectors["arm"].joints)
        self._motion, self._commands = Shared(1 + joints), Shared(1 + joints)
        self._faults, self._words = Shared(1), Path(f"/tmp/cbdsl_trial_{os.getpid()}")
        self._delay = float(self._rng.uniform(0.3, _MOTION))

    def run(self) -> Outcome:
        """Run the trial."""
        self._words.write_text("")
        served = fork(self._serve)
        self._await(lambda: len(self._motion.rows) > 10)
        program = fork(self._run_program)
        children = [served, program, *([fork(self._guard)] if self._guarded else [])]
        try:
            self._await(lambda: self._moves() or _ended(program))
            time.sleep(self._delay if self._kind not in _SERVED else 0.0)
            begun = self._inject(served, program, children)
            self._await(lambda: _ended(program), 6.0)
            time.sleep(0.3)
        finally:
            for child in children:
                _kill(child)
        return self._outcome(begun)

    def _moves(self) -> bool:
        return len(self._commands.rows) > 3

    def _await(self, done: Callable[[], bool], patience: float = 20.0) -> None:
        until = time.monotonic() + patience
        while not done() and time.monotonic() < until:
            time.sleep(0.005)

    def _serve(self, *, restarted: bool = False) -> None:
        from cbdsl_ros2.injected_faults import Faults, InjectedFault
        from cbdsl_ros2.topic_server import RobotServer, simulated_robot

        document = self._standing() if restarted else self._robot
        served = simulated_robot("kinematic", document, self._urdf)
        kind = _SERVED.get(self._kind)
        faults = Faults(() if kind is None or restarted else [InjectedFault(kind, 1e9)], self._seed)
        server = RobotServer(self._robot, self._urdf, served, None, faults)
        server.reset(_stage(self._robot), None, self._seed)

        def note(moment: Any) -> bool:
            self._motion.add(np.concatenate([[moment.time], moment.positions]))
            if len(self._commands.rows) > 3 and kind is not None and not faults.begun:
                if not hasattr(note, "since"):
                    note.since = moment.time  # type: ignore[attr-defined]
                if moment.time - note.since > self._delay:  # type: ignore[attr-defined]
                    faults.start_now()
            for begun in list(faults.begun.values())[len(self._faults.rows) :]:
                self._faults.add(np.array([begun]))
            return True

        server.serve(note)

    def _guard(self) -> None:
        from cbdsl_ros2.guard import Guard

        Guard(self._robot, self._urdf).watch(lambda line: None, lambda: False)

    def _standing(self) -> RobotDocument:
        """Return the robot with its last posture as start posture."""
        arm = self._robot.effectors["arm"]
        postures = {**arm.postures, "last": tuple(self._motion.rows[-1, 1:].tolist())}
        standing = arm.model_copy(update={"postures": postures, "start": "last"})
        return self._robot.model_copy(update={"effectors": {"arm": standing}})

    def _run_program(self) -> None:
        from cbdsl.backends.drivers.backend import DrivenBackend
        from cbdsl.backends.drivers.person import Consent
        from cbdsl.checking.program import check_program
        from cbdsl.kinematics.kinematics import Kinematics
        from cbdsl.runtime.episode import Runner
        from cbdsl.yaml_text.library import Library

        program = check_program("sixaxis_reach", {}, Library(ROOT))
        driven = DrivenBackend(self._robot, self._urdf, opener=self._open)
        driven.attend(Consent())
        kinematics = Kinematics(self._robot, self._urdf)
        runner = Runner(self._robot, kinematics, program, driven)
        try:
            words = runner.run(_stage(self._robot), self._seed).ending
        except Exception as error:
            words = str(error)
        self._words.write_text(words)
        driven.close()

    def _open(self, document: RobotDocument, interface: str | None) -> list[_Tapped]:
        from cbdsl.backends.drivers.link import open_links

        return [_Tapped(link, self._commands) for link in open_links(document, interface)]

    def _inject(self, served: int, program: int, children: list[int]) -> float:
        """Let the fault happen; return its time, s since the epoch."""
        begun = time.time()
        match self._kind.removeprefix("guarded "):
            case "program killed":
                _signal(program, signal.SIGKILL)
            case "robot killed":
                _signal(served, signal.SIGKILL)
            case "program suspended" | "robot suspended":
                child = served if self._kind.startswith("robot") else program
                _signal(child, signal.SIGSTOP)
                time.sleep(SUSPENDED)
                _signal(child, signal.SIGCONT)
            case "robot restarted":
                _signal(served, signal.SIGKILL)
                children.append(fork(lambda: self._serve(restarted=True)))
                time.sleep(0.5)
            case "two commanders":
                children.append(fork(self._command))
                self._await(lambda: len(self._faults.rows) > 0)
                begun = float(self._faults.rows[0, 0]) if len(self._faults.rows) else begun
            case _:
                self._await(lambda: len(self._faults.rows) > 0)
                begun = float(self._faults.rows[0, 0]) if len(self._faults.rows) else begun
        return begun

    def _command(self) -> None:
        """Command the robot as a second program would."""
        from cbdsl_ros2.ros2_link import Ros2Link

        link = Ros2Link(self._robot, self._robot.drivers, None)
        link.claim()
        names = self._robot.effectors["arm"].joints
        self._faults.add(np.array([time.time()]))
        while True:
            link.send("arm", Command(names, (0.0,) * len(names), 0.05, time.time()))
            time.sleep(1 / 60)

    def _outcome(self, begun: float) -> Outcome:
        motion, commands = self._motion.rows, self._commands.rows
        times = motion[1:, 0]
        elapsed = np.maximum(np.diff(motion[:, 0]), 1.0 / 240.0)
        speeds = np.abs(np.diff(motion[:, 1:], axis=0)).max(axis=1) / elapsed
        before = (times > begun - 0.1) & (times <= begun + 0.02)
        # A loss holds the robot at some time, if at all: its last command counts.
        begun = float(commands[-1, 0]) if self._kind == "loss" and len(commands) else begun
        after = times[(times > begun) & (speeds > SLOW)]
        still = float(after[-1] - begun) if len(after) else 0.0
        return Outcome(
            self._kind, self._seed, round(still, 4), bool((speeds[before] > SLOW).any()),
            len(commands), self._violations(commands[:, 1:]), self._words.read_text(),
        )  # fmt: skip

    def _violations(self, commands: np.ndarray) -> int:
        from cbdsl.backends.drivers.joint_limits import joint_limits
        from cbdsl.robot.urdf_reader import read_urdf

        limits, period = joint_limits(self._robot, read_urdf(self._urdf)), 1.0 / 60.0
        inside = (commands >= limits.lower - 1e-9) & (commands <= limits.upper + 1e-9)
        velocities = np.diff(commands, axis=0) / period
        fast = np.abs(velocities) > limits.velocity + 1e-6
        jerky = np.abs(np.diff(velocities, axis=0)) > limits.acceleration * period + 1e-6
        broken = ~np.isfinite(commands) | ~inside
        return int(broken.any(axis=1).sum() + fast.any(axis=1).sum() + jerky.any(axis=1).sum())


_SERVED = {
    "stall": "stall", "loss": "loss", "clock": "clock", "swap": "swap", "missing": "missing",
    "double": "double",
    "nan": "nan", "frozen": "frozen", "effort": "effort",
}  # fmt: skip


class _Tapped:
    """Link whose commands are written down.

    Args:
        link: Link to a robot.
        commands: Times and positions of the commands.
    """

    def __init__(self, link: DriverLink, commands: Shared) -> None:
        self._link, self._commands = link, commands
        self.poll, self.survey, self.close = link.poll, link.survey, link.close
        self.claim = link.claim

    def send(self, driver: str, command: Command) -> None:
        self._commands.add(np.array([time.time(), *command.positions]))
        self._link.send(driver, command)


def _stage(document: RobotDocument) -> Any:
    from cbdsl.api.reading.robots import read_stage

    return read_stage(None, document)


def _ended(child: int) -> bool:
    try:
        return os.waitpid(child, os.WNOHANG)[0] != 0
    except ChildProcessError:
        return True


def _signal(child: int, number: signal.Signals) -> None:
    """Send a signal to a process that may have ended."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(child, number)


def _kill(child: int) -> None:
    _signal(child, signal.SIGKILL)
    with contextlib.suppress(ChildProcessError):
        os.waitpid(child, 0)


def warm() -> None:
    """Import and compile everything before the first fork, without a thread of DDS."""
    from cbdsl.backends.drivers import backend  # noqa: F401
    from cbdsl.checking.program import check_program
    from cbdsl.kinematics.kinematics import Kinematics
    from cbdsl.runtime.episode import Runner
    from cbdsl.yaml_text.library import Library
    from cbdsl_ros2 import guard, ros2_link, topic_server  # noqa: F401

    document, urdf = robot()
    served = topic_server.simulated_robot("kinematic", document, urdf)
    program = check_program("sixaxis_reach", {}, Library(ROOT))
    Runner(document, Kinematics(document, urdf), program, served).run(_stage(document), 0)
    served.close()


def is_passed(outcome: Outcome) -> bool:
    """Return True if the robot stopped in time, no limit was broken and the cause was named."""
    if outcome.kind in HARMLESS:
        still = outcome.kind == "swap" or outcome.still <= STILL
        return outcome.violations == 0 and bool(outcome.cause) and still
    # A suspended program may also be stopped by the deadline of its control tick.
    named = outcome.kind.endswith("program killed") or "held: " in outcome.cause
    named |= "deadline" in outcome.cause
    return outcome.moving and outcome.still <= STILL and outcome.violations == 0 and named


def summary(lines: list[str]) -> str:
    """Return a table of outcomes: passed trials with exact intervals, and the slowest stop."""
    from cbdsl.numeric.proportion import exact_interval

    outcomes = [json.loads(line) for line in lines]
    rows = ["| fault | passed | 95 % interval | median still, ms | longest, ms | violations |"]
    rows.append("| --- | --- | --- | --- | --- | --- |")
    for kind in KINDS:
        own = [outcome for outcome in outcomes if outcome["kind"] == kind]
        if not own:
            continue
        passed = sum(outcome["passed"] for outcome in own)
        low, high = exact_interval(passed, len(own))
        still = [1e3 * each["still"] for each in own if "held" in each["cause"] or each["moving"]]
        counts = kind not in HARMLESS
        times = f"{np.median(still):.0f} | {max(still):.0f}" if counts else "- | -"
        broken = sum(outcome["violations"] for outcome in own)
        interval = f"{100 * low:.1f} to {100 * high:.1f} %"
        rows.append(f"| {kind} | {passed} of {len(own)} | {interval} | {times} | {broken} |")
    return "\n".join(rows)


def main() -> None:
    """Run trials, or print a table of earlier ones."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kinds", nargs="*", default=KINDS)
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--out", type=Path, default=Path("build/faults.jsonl"))
    parser.add_argument("--summary", nargs="*", type=Path)
    options = parser.parse_args()
    if options.summary:
        lines = [line for path in options.summary for line in path.read_text().splitlines()]
        sys.stdout.write(summary(lines) + "\n")
        return
    options.out.parent.mkdir(parents=True, exist_ok=True)
    until = time.monotonic() + options.seconds
    lines = options.out.read_text().splitlines() if options.out.is_file() else []
    done = {(row["kind"], row["seed"]) for row in map(json.loads, lines)}
    warm()
    for seed in range(options.first, options.first + options.count):
        for kind in options.kinds:
            if (kind, seed) in done:
                continue
            if time.monotonic() > until:
                return
            outcome = Trial(kind, seed).run()
            line = json.dumps({**outcome._asdict(), "passed": is_passed(outcome)})
            with options.out.open("a") as file:
                file.write(line + "\n")
            sys.stdout.write(line + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
