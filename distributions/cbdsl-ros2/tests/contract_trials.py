"""Contract trials: a robot cell, and a program that the safety contract has to hold.

``CB_RCLPY=PYTHON python contract_trials.py --count 20`` runs each kind of fault 20 times at each of
its rates, into ``build/contract.jsonl``; trials of this file are not repeated. ``--kinds`` selects
kinds, ``--load`` keeps all processors busy, and ``--minutes`` ends the campaign. ``--summary``
prints a table with exact 95 % intervals, busy and quiet trials apart. The arm, its buttons and
rivals are nodes of rclpy with Fast DDS (``rclpy_cell.py``), or the arm is that of ``cb drive
serve``, with Cyclone DDS. The program is ``cb run`` with several episodes, and the watchdog
``cb drive watchdog``. The fault comes in one of the first two episodes, or on the way back between
them.
"""

from __future__ import annotations

import argparse
import fcntl
import json
import math
import os
import pty
import shutil
import signal
import subprocess
import sys
import tempfile
import termios
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from cbdsl.extend.backend import Floats, RobotDocument

ROOT = Path(__file__).parents[3]
CELL = Path(__file__).with_name("rclpy_cell.py")
CB = (sys.executable, "-c", "from cbdsl.cli.main import main; main()")
DOMAIN = os.environ.get("ROS_DOMAIN_ID", "91")
#: Longest time until the arm is still or the program holds, s; speed of an arm that is still.
STILL, SLOW = 0.15, 0.02
# Longest time between two messages of a button, s, and time for which a process is suspended.
_SILENT, _SUSPENDED = 0.25, 0.6
# Most trials until one has a fault that comes while a served arm moves.
_ATTEMPTS = 4
# Time after which commands begin anew, s.
_PAUSE = 0.3
# Load above which a computer is busy.
_BUSY = 4.0
FAST, CYCLONE = NODES = "Fast DDS", "Cyclone DDS"


class Kind(NamedTuple):
    """Fault of a trial.

    Attributes:
        rates: Control rates, Hz.
        cause: Words of the program's last line, with alternatives.
        form: Form of the driver.
        before: True if the fault is there before the program, which is then never ready.
        still: True if the arm has to be still after the fault, and not only the program held.
        within: Longest time until then, s. It begins with the fault, or with the first command of
            a rival. A program that died, ``None``, has the time that the document states for it,
            and at most the time of all faults.
        way: Motion after the fault that passes after any time, rad.
        nodes: Nodes of the arm. Served arms have the rate of 60 Hz alone.
        harmless: True if the program survives the fault, and is then interrupted. Only lost
            messages may hold it.
        watched: Words of the watchdog, which has to hold and end. An arm also stops at its newest
            reference if its watchdog repeats that for ever.
    """

    rates: tuple[float, ...]
    cause: str
    form: str = "trajectory"
    before: bool = False
    still: bool = False
    within: float | None = STILL
    way: float = 0.0
    nodes: tuple[str, ...] = (FAST,)
    harmless: bool = False
    watched: str = ""


_INTERRUPTED = "hangup", "terminal closed"
_RIVAL = "another commander writes to|the watchdog"
ALL = (30.0, 60.0, 250.0)
KINDS = {
    "no fault": Kind((60.0,), "", nodes=NODES, harmless=True),
    "rival of a watchdog": Kind(ALL, _RIVAL, "positions"),
    "rival of a watchdog before": Kind((60.0,), "another commander", "positions", before=True),
    "second program of a watchdog": Kind((60.0,), _RIVAL, "positions", still=True),
    "rival of a trajectory": Kind(ALL, "another commander writes to /controller/joint_trajectory"),
    "rival of a trajectory before": Kind((60.0,), "another commander writes to", before=True),
    "deaf button before": Kind((60.0,), "is best effort, and has to be reliable", before=True),
    "deaf button": Kind((60.0,), "is best effort, and has to be reliable"),
    "goal": Kind((60.0,), "a goal of action /controller/follow_joint_trajectory is executing"),
    "goal before": Kind((60.0,), "a goal of action", before=True),
    "mute button before": Kind((60.0,), "has sent no state", before=True),
    "pressed": Kind(ALL, "is pressed", still=True),
    "button killed": Kind(ALL, "is silent for", still=True, within=_SILENT + STILL),
    "button hung": Kind(ALL, "is silent for", still=True, within=_SILENT + STILL),
    "second button killed": Kind((60.0,), "is silent", still=True, within=_SILENT + STILL),
    "carried": Kind(ALL, "away from its references"),
    "exchanged": Kind(ALL, "joint '", still=True),
    "exchanged before": Kind((60.0,), "joint '", still=True),
    "clock back": Kind(ALL, "clock", still=True),
    "clock ahead": Kind(ALL, "clock", still=True),
    "hangup": Kind(ALL, "", still=True),
    "terminal closed": Kind((60.0,), "", still=True),
    "killed": Kind((*ALL, 20.0), "", still=True, within=None, nodes=NODES),
    "suspended": Kind((60.0,), "suspended|deadline|in time", still=True, nodes=NODES),
    "killed before a watchdog": Kind(
        (60.0,), "", "positions", still=True, within=None, watched="no reference for"
    ),
    "suspended before a watchdog": Kind(
        (60.0,), "suspended|deadline", "positions", still=True, watched="no reference for"
    ),
    "watchdog killed": Kind((60.0,), "watchdog|frozen", "positions", still=True),
    "watchdog suspended": Kind((60.0,), "watchdog|frozen", "positions", still=True),
    "arm killed": Kind((60.0,), "has ended|no new state", nodes=NODES),
    "arm suspended": Kind((60.0,), "no new state|stamped", still=True, nodes=NODES),
    # Faults of ``cb drive serve --fault``.
    "stall": Kind((60.0,), "no new state|stamped", still=True, nodes=NODES),
    "loss": Kind((60.0,), "", nodes=NODES, harmless=True),
    "clock": Kind((60.0,), "clock", still=True, nodes=(CYCLONE,)),
    "swap": Kind((60.0,), "", nodes=NODES, harmless=True),
    "missing": Kind((60.0,), "state of joint", still=True, nodes=NODES),
    "double": Kind((60.0,), "twice", still=True, nodes=NODES),
    "nan": Kind((60.0,), "nan", still=True, nodes=NODES),
    # A reference has to move until frozen states are noticed.
    "frozen": Kind((60.0,), "frozen", still=True, way=0.05, nodes=NODES),
    "effort": Kind((60.0,), "effort", still=True, nodes=NODES),
}
_INJECTED = (
    "stall", "loss", "clock", "swap", "missing", "double", "nan", "frozen", "effort",
)  # fmt: skip
# Faults that end the program; and signals of a process whose name comes before, or of the program.
_ENDED = (*_INTERRUPTED, "killed", "killed before a watchdog")
_SIGNALS = {
    "hangup": signal.SIGHUP, "killed": signal.SIGKILL, "hung": signal.SIGSTOP,
    "suspended": signal.SIGSTOP,
}  # fmt: skip


class Outcome(NamedTuple):
    """Outcome of a trial.

    Attributes:
        kind, rate, seed, node: Trial.
        moving: True if the arm moved when the fault came, as far as it wrote its motion.
        time: Time from the fault until the arm was still, or until its last command, s; NaN if the
            arm was killed.
        way: Largest motion of a joint after the fault, rad; NaN if the arm was killed.
        commands: Commands after the fault.
        violations: Commands to the arm of rclpy beyond a limit of position, velocity or
            acceleration, or not finite.
        cause: Last words of the program.
        passed: True if the contract held in time.
        held: True if the contract held but for the time.
        bound: Time that the document states for this fault, s, without a silence of a button. It
            informs, and does not judge.
        load: Processes that were running or waiting at the end of the trial, on average over a
            minute.
    """

    kind: str
    rate: float
    seed: int
    moving: bool
    time: float
    way: float
    commands: int
    violations: int
    cause: str
    passed: bool
    held: bool
    bound: float
    node: str = FAST
    load: float = math.nan


class Trial:
    """One trial in a folder of its own.

    Args:
        name: Kind.
        rate: Control rate, Hz.
        seed: Seed of the posture and of the time of the fault.
        node: Node of the arm.
    """

    def __init__(self, name: str, rate: float, seed: int, node: str = FAST) -> None:
        self._node, self._later = node, 0.0
        self._name, self._kind, self._rate, self._seed = name, KINDS[name], rate, seed
        self._rng = np.random.default_rng([seed, list(KINDS).index(name), round(rate)])
        self._folder = Path(tempfile.mkdtemp(prefix="contract_"))
        self._trace = self._folder / "motion.jsonl"
        self._environment = {
            **os.environ,
            "ROS_DOMAIN_ID": DOMAIN,
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        }

    def run(self) -> Outcome:
        """Run the trial."""
        names = self._write_documents()
        try:
            with ExitStack() as cell:
                return self._run(names, cell)
        finally:
            shutil.rmtree(self._folder)

    def _write_documents(self) -> dict[str, float]:
        """Write robot and program; return a start of the joints near the posture ``aside``."""
        for file in (
            "robots/sixaxis.*",
            "programs/poise.yaml",
            "programs/stages/sixaxis_*",
        ):
            for path in ROOT.glob(file):
                copy = self._folder / path.relative_to(ROOT)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(path, copy)
        robot = self._folder / "robots" / "sixaxis.yaml"
        topic = "commands" if self._kind.form == "positions" else "joint_trajectory"
        driver = {
            "kind": "ros2",
            "moves": ["arm"],
            "states": "/joint_states",
            "commands": f"/controller/{topic}",
            "form": self._kind.form,
            "stop": "/emergency_stop",
            "stop_deadline": f"{_SILENT} s",
            "deadline": f"{max(0.05, 1.5 / self._rate)} s",
            "start": max(0.05, 2.0 / self._rate),
        }
        text = robot.read_text("utf-8").replace("rate: 120 Hz", f"rate: {self._rate:g} Hz")
        # Physics steps are a multiple of control ticks.
        physics = self._rate * -(-240 // self._rate)
        text = text.replace("simulation:\n", f"simulation:\n  physics_rate: {physics:g} Hz\n")
        robot.write_text(f"{text}\ndrivers: {json.dumps({'arm': driver})}\n", "utf-8")
        names = ("waist", "shoulder", "elbow", "forearm_roll", "wrist_bend", "flange_roll")
        aside = np.array([1.2, 0.2, 0.2, 0.4, 0.8, 0.5]) + self._rng.uniform(-0.03, 0.03, 6)
        return dict(zip(names, aside.tolist(), strict=True))

    def _run(self, joints: dict[str, float], cell: ExitStack) -> Outcome:
        name, common = self._name, {"form": self._kind.form, "joints": joints}
        settings = {**common, "rate": self._rate, "trace": str(self._trace)}
        settings["exchanged"] = name == "exchanged before"
        if self._node == FAST:
            arm = cell.enter_context(self._part("arm", settings))
            button = cell.enter_context(self._part("button", {"period": 0.05}))
        else:
            arm = button = cell.enter_context(self._command("drive", "serve", "sixaxis"))
        parts = {"arm": arm, "button": button}
        if name == "second button killed":
            parts["second"] = cell.enter_context(self._part("button", {"period": 0.05}))
        if self._kind.form == "positions":
            parts["watchdog"] = cell.enter_context(self._command("drive", "watchdog", "sixaxis"))
        if self._kind.before:
            self._intrude(cell, common)
        words = (
            "run",
            "poise",
            "--robot",
            "sixaxis",
            "--backend",
            "ros2",
            "--yes",
            "--record",
            "out",
        )
        self._terminal = -1
        count = "2" if name == "no fault" else "12"
        program = cell.enter_context(self._command(*words, "--overwrite", "--episodes", count))
        begun = time.time()
        if name == "no fault":
            program.wait(120)
        elif not self._kind.before:
            # Episode, way back, and the next episode.
            turn = 1 if settings["exchanged"] else 1 + self._seed % 3
            word = "moves" if self._node == FAST else "set up stage"
            # A served arm moves some time after its stage is set up.
            later = 0.0 if self._node == FAST else 0.5
            if all(_awaits(arm, word, program) for _ in range(turn)) and not settings["exchanged"]:
                time.sleep(later + float(self._rng.uniform(0.2, 1.0)))
            begun = self._fault({**parts, "program": program}, cell, common)
        if self._kind.harmless and name != "no fault":
            time.sleep(1.0)
            program.terminate()
        said, watches = self._last_words(program), self._watches(parts)
        time.sleep(0.3)
        arm.terminate()
        arm.wait(10)
        outcome = self._outcome(begun, program.returncode, said)
        held, passed = outcome.held and watches, outcome.passed and watches
        return outcome._replace(held=held, passed=passed)

    def _last_words(self, program: subprocess.Popen[str]) -> str:
        try:
            said = program.communicate(timeout=30)[1] or ""
        except subprocess.TimeoutExpired:
            # It was not held, such as by a suspension at rest.
            program.terminate()
            said = program.communicate(timeout=60)[1] or ""
        return said.strip()

    def _watches(self, parts: dict[str, subprocess.Popen[str]]) -> bool:
        """Return whether the watchdog held, and ended, where it has to."""
        if not self._kind.watched:
            return True
        try:
            return self._kind.watched in parts["watchdog"].communicate(timeout=5)[0]
        except subprocess.TimeoutExpired:
            return False

    @contextmanager
    def _part(self, part: str, settings: dict[str, object]) -> Iterator[subprocess.Popen[str]]:
        """Run a part of the cell; it is ready."""
        command = [os.environ["CB_RCLPY"], str(CELL), part, json.dumps(settings)]
        process = subprocess.Popen(
            command, env=self._environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            yield process
        finally:
            process.kill()
            process.wait()

    @contextmanager
    def _command(self, *words: str) -> Iterator[subprocess.Popen[str]]:
        out, err = subprocess.PIPE, subprocess.DEVNULL
        if words[1] == "serve":
            words += ("--backend", "kinematic", "--trace", str(self._trace))
            if self._name in _INJECTED:
                # A program on a busy computer has begun by then, and the arm moves mostly.
                self._later = float(self._rng.uniform(25.0, 30.0))
                words += ("--fault", f"{self._name}@{self._later:.2f}")
        if words[0] == "run":
            out, err = subprocess.DEVNULL, subprocess.PIPE
        options: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": out, "stderr": err}
        if words[0] == "run" and self._name == "terminal closed":
            self._terminal, end = pty.openpty()
            # The program's session loses its terminal once this process closes the other end.
            claim = lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0)  # noqa: E731
            options = {"stdin": end, "stdout": end, "stderr": end, "preexec_fn": claim}
            options["start_new_session"] = True
        process = subprocess.Popen(
            [*CB, *words], cwd=self._folder, env=self._environment, text=True, **options
        )
        if "preexec_fn" in options:
            os.close(end)
        try:
            if words[0] == "drive":
                assert process.stdout is not None
                assert process.stdout.readline().startswith(("guarding", "serving"))
                self._later += time.time()
            yield process
        finally:
            process.kill()
            process.wait()

    def _intrude(self, cell: ExitStack, common: dict[str, object]) -> None:
        """Add the rival or the button that is the fault."""
        match self._name.removesuffix(" before"):
            case "deaf button":
                settings = {"best_effort": True, "pressed": True}
                cell.enter_context(self._part("button", settings))
            case "mute button":
                cell.enter_context(self._part("button", {"period": 1e3}))
            case "goal":
                cell.enter_context(self._part("goal", {}))
            case name:
                common = {**common, "guarded": name.startswith("second program")}
                cell.enter_context(self._part("rival", common))

    def _fault(
        self, parts: dict[str, subprocess.Popen[str]], cell: ExitStack, common: dict[str, object]
    ) -> float:
        """Let the fault happen; return its time, s since the epoch."""
        sign, name = self._rng.choice([-1.0, 1.0]), self._name
        lines = {
            "carried": f"carry {sign * self._rng.uniform(0.4, 1.2)}",
            "exchanged": "exchange",
            "clock back": "clock -0.3",
            "clock ahead": "clock 0.3",
            "pressed": "press",
        }
        begun = time.time()
        if name in _INJECTED and self._node == CYCLONE:
            time.sleep(max(0.0, self._later - begun))
            return time.time()
        words = name.split()
        faulty = parts.get(words[0], parts["program"])
        sent = [_SIGNALS[word] for word in words if word in _SIGNALS]
        if name in lines or name in _INJECTED:
            stream = parts["button" if name == "pressed" else "arm"].stdin
            assert stream is not None
            stream.write(lines.get(name, name) + "\n")
            stream.flush()
        elif name == "terminal closed":
            os.close(self._terminal)
        elif sent:
            faulty.send_signal(sent[0])
            if "suspended" in words:
                time.sleep(_SUSPENDED)
                faulty.send_signal(signal.SIGCONT)
        elif name != "exchanged before":
            self._intrude(cell, common)
            # Ready, it exists, and its first message follows.
            begun = time.time()
        return begun

    def _motion(self) -> tuple[Floats, Floats, Floats, Floats, float]:
        """Return times, positions, times and positions of commands, and the time of the fault."""
        if self._node == CYCLONE:
            with np.load(self._trace) as motion:
                reference, times = motion["reference"], motion["time"]
                changed = np.flatnonzero(np.diff(reference, axis=0).any(axis=1)) + 1
                faults = motion["faults"]
                fault = float(faults[0]) if len(faults) else 0.0
                return times, motion["positions"], times[changed], reference[:0], fault
        *rows, sent = map(json.loads, self._trace.read_text().splitlines())
        times, positions = (np.array([row[part] for row in rows]) for part in (0, 1))
        commands = np.unique([row[2] for row in rows])
        return times, positions, commands, np.array(sent), rows[-1][3]

    def _outcome(self, begun: float, code: int, said: str) -> Outcome:
        if not self._trace.exists():
            # A killed arm writes no motion, and its program has to notice.
            held = "is held" in said and any(c in said for c in self._kind.cause.split("|"))
            held = held and self._name == "arm killed"
            return self._row(False, math.nan, math.nan, 0, 0, said, held, held)
        times, positions, commands, sent, fault = self._motion()
        if fault and not self._kind.before:
            begun = fault
        after = commands[commands > begun]
        if self._name == "loss" and len(after):
            # Lost messages hold the robot at some time, if at all.
            begun = float(after[-1])
        speeds = np.abs(np.diff(positions, axis=0)).max(axis=1) / np.diff(times)
        # A rival may be noticed before its first command.
        came = min([begun, *commands[-1:]])
        around = (times[1:] > came - 0.1) & (times[1:] < came + 0.02)
        moving = bool((speeds[around] > SLOW).any())
        late = times[1:][(times[1:] > begun) & (speeds > SLOW)]
        ends = late if self._kind.still else after
        elapsed = float(ends[-1] - begun) if len(ends) else 0.0
        later = positions[times > begun]
        way = float(np.abs(later - later[0]).max()) if len(later) else 0.0
        soon = True
        if self._kind.before:
            held = "is not ready" in said and not len(after)
        else:
            # Between two episodes, the next one does not begin.
            held = "is held" in said or "is not ready" in said or self._name in _ENDED
            held = held and moving
            soon = elapsed <= self._within() or way <= self._kind.way
        if self._kind.harmless and not (self._name == "loss" and held):
            moved = bool((speeds > SLOW).any())
            held, soon = moved and code == (0 if self._name == "no fault" else 130), True
        if self._name.startswith("killed"):
            # A program that was held shortly before has not been killed.
            held = held and code == -signal.SIGKILL
        if self._name in _INTERRUPTED:
            held = held and code == 130 and any((self._folder / "out").rglob("*.npz"))
        held = held and any(cause in said for cause in self._kind.cause.split("|"))
        violations = self._violations(sent)
        held = held and not violations
        return self._row(moving, elapsed, way, len(after), violations, said, held, held and soon)

    def _row(
        self, moving: bool, elapsed: float, way: float, commands: int, violations: int, said: str,
        held: bool, passed: bool,
    ) -> Outcome:  # fmt: skip
        cause = said.splitlines()[-1][-300:] if said else ""
        return Outcome(
            self._name, self._rate, self._seed, moving, round(elapsed, 4), round(way, 3), commands,
            violations, cause, passed, held, round(self._bound(), 4), self._node,
            round(os.getloadavg()[0], 1),
        )  # fmt: skip

    def _violations(self, sent: Floats) -> int:
        """Return how many commands break a limit.

        Args:
            sent: Times and positions of commands, shape (commands, 1 + n).
        """
        from cbdsl.extend.backend import read_fitting
        from cbdsl_drive.joint_limits import joint_limits

        if len(sent) < 3:
            return 0
        document, urdf = self._documents()
        limits, period = joint_limits(document, read_fitting(document, urdf)), 1.0 / self._rate
        # After a pause, the controller has come to rest.
        paused = np.diff(sent[:, 0]) > _PAUSE
        sent = sent[:, 1:]
        inside = (sent >= limits.lower - 1e-9) & (sent <= limits.upper + 1e-9)
        velocities = np.where(paused[:, None], 0.0, np.diff(sent, axis=0) / period)
        # An episode begins where the last one has settled, up to 0.1 mrad.
        fast = np.abs(velocities) > 1.01 * limits.velocity
        # The first step after a pause is unknown, so two steps from rest are allowed to the second.
        steps = np.where(paused[:-1, None], 2.0, 1.01)
        jerky = np.abs(np.diff(velocities, axis=0)) > steps * limits.acceleration * period + 0.03
        jerky &= ~paused[1:, None]
        broken = ~np.isfinite(sent) | ~inside
        return int(broken.any(axis=1).sum() + fast.any(axis=1).sum() + jerky.any(axis=1).sum())

    def _documents(self) -> tuple[RobotDocument, Path]:
        from cbdsl.api.reading.robots import read_robot

        return read_robot(self._folder / "robots" / "sixaxis.yaml")

    def _within(self) -> float:
        """Return the longest time until the arm is still or the program holds, s."""
        within = self._kind.within
        return min(STILL, self._bound()) if within is None else within

    def _bound(self) -> float:
        """Return the time that the document states, s."""
        from cbdsl.robot.stopping_time import stopping_time
        from cbdsl.robot.urdf_reader import read_urdf

        document, urdf = self._documents()
        stated = stopping_time(document, read_urdf(urdf), "arm")
        ended = self._name.startswith(("killed", "suspended"))
        return stated.death if ended else stated.fault


def _awaits(process: subprocess.Popen[str], word: str, other: subprocess.Popen[str]) -> bool:
    """Wait for a line of a process until another one ends; return whether it came."""
    assert process.stdout is not None
    os.set_blocking(process.stdout.fileno(), False)
    while other.poll() is None:
        if (process.stdout.readline() or "").startswith(word):
            return True
        time.sleep(0.005)
    return False


def summary(lines: list[str]) -> str:
    """Return a table of outcomes: trials that held in time, later and not, and their times."""
    from cbdsl.numeric.proportion import exact_interval

    outcomes = [Outcome(**json.loads(line)) for line in lines]
    heads = ("fault", "node", "rate, Hz", "load", "in time", "95 % interval", "later", "not held")
    heads += ("median, ms", "longest, ms", "document, ms")
    rows = [f"| {' | '.join(heads)} |", "| --- " * len(heads) + "|"]
    trial = lambda each: (each.kind, each.node, each.rate, each.load >= _BUSY)  # noqa: E731
    for name, node, rate, is_busy in sorted(set(map(trial, outcomes))):
        trials = [each for each in outcomes if trial(each) == (name, node, rate, is_busy)]
        passed, held = (sum(getattr(each, a) for each in trials) for a in ("passed", "held"))
        low, high = exact_interval(passed, len(trials))
        times = [1e3 * each.time for each in trials]
        is_timed = not KINDS[name].before and np.isfinite(times).all()
        shown = f"{np.median(times):.0f} | {max(times):.0f}" if is_timed else "- | -"
        interval = f"{100 * low:.1f} to {100 * high:.1f} %"
        rows.append(
            f"| {name} | {node} | {rate:g} | {'busy' if is_busy else 'quiet'} "
            f"| {passed} of {len(trials)} | {interval} | {held - passed} | {len(trials) - held} "
            f"| {shown} | {1e3 * trials[0].bound:.0f} |"
        )
    return "\n".join(rows)


def selected(kinds: Iterable[str]) -> Iterator[tuple[str, str, float]]:
    """Yield kind, node and rate of each sort of trial."""
    for name in kinds:
        for node in KINDS[name].nodes:
            for rate in KINDS[name].rates if node == FAST else (60.0,):
                yield name, node, rate


def attempt(name: str, rate: float, seed: int, node: str) -> Outcome:
    """Run a trial; a served arm may stand when its fault comes, and is tried with other times."""
    for number in range(_ATTEMPTS if node == CYCLONE else 1):
        outcome = Trial(name, rate, seed + 1000 * number, node).run()
        if outcome.moving or outcome.passed:
            break
    return outcome._replace(seed=seed)


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Keep some processors busy."""
    idlers = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for idler in idlers:
            idler.kill()
            idler.wait()


def main() -> int:
    """Run trials, or print a table of earlier ones; return 1 if one failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--rates", nargs="*", type=float)
    parser.add_argument("--nodes", nargs="*", default=NODES, choices=NODES)
    parser.add_argument("--load", action="store_true")
    parser.add_argument("--minutes", type=float, default=math.inf)
    parser.add_argument("--out", type=Path, default=Path("build/contract.jsonl"))
    parser.add_argument("--summary", nargs="*", type=Path, help="files of outcomes [--out]")
    options = parser.parse_args()
    if options.summary is not None:
        files = options.summary or [options.out]
        if missing := [str(path) for path in files if not path.is_file()]:
            parser.error(f"there is no file of outcomes {', '.join(missing)}")
        lines = [line for path in files for line in path.read_text().splitlines()]
        sys.stdout.write(summary(lines) + "\n")
        return 0
    options.out.parent.mkdir(parents=True, exist_ok=True)
    lines = options.out.read_text().splitlines() if options.out.is_file() else []
    done = {(r["kind"], r["node"], r["rate"], r["seed"]) for r in map(json.loads, lines)}
    failed, until = False, time.monotonic() + 60.0 * options.minutes
    with busy(os.cpu_count() or 1 if options.load else 0):
        for seed, (name, node, rate) in product(
            range(options.first, options.first + options.count), selected(options.kinds)
        ):
            left_out = node not in options.nodes or (options.rates and rate not in options.rates)
            if left_out or (name, node, rate, seed) in done:
                continue
            if time.monotonic() > until:
                break
            outcome = attempt(name, rate, seed, node)
            failed |= not outcome.passed
            line = json.dumps(outcome._asdict())
            with options.out.open("a") as file:
                file.write(line + "\n")
            sys.stdout.write(line + "\n")
            sys.stdout.flush()
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
