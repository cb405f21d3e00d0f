"""Serving: simulated robots behind the topics of their drivers."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.extend.backend import RobotDocument
    from cbdsl_ros2.topic_server import Moment

# Window of the real-time factor, s, and the factor below which it is reported.
_WINDOW, _SLOW = 5.0, 0.97


def serve_robot(
    robot: str | Path,
    *,
    backend: str = "mujoco",
    stage: str | Path | None = None,
    context: str | None = None,
    seed: int = 0,
    cameras: str | None = None,
    rate: float | None = None,
    faults: Sequence[str] = (),
    trace: Path | None = None,
    seconds: float | None = None,
    interface: str | None = None,
    report: Callable[[str], None] = lambda line: None,
    stopped: Callable[[], bool] = lambda: False,
) -> None:
    """Serve a simulated robot in real time.

    Args:
        robot: File or name of the robot.
        backend: Simulated robot's backend.
        stage: File or name of the stage of all episodes. If ``None``, it is empty until a program
            requests the stage of its episodes.
        context: Context of the stage; drawn by share if ``None``.
        seed: Seed of the stage until a program requests one by its own seed.
        cameras: ``rendered`` or ``ideal``; the backend's choice if ``None``.
        rate: Control rate, Hz; that of the robot's document if ``None``.
        faults: Faults, such as ``nan@2.5``.
        trace: NPZ file for the robot's motion.
        seconds: Time after which it ends; never if ``None``.
        interface: Network interface; loopback only if ``None``.
        report: Function called with each line of output.
        stopped: Function that returns whether to end.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed, or does not fit.
    """
    from cbdsl.extend.backend import read_fitting, read_robot, read_stage, with_control_rate
    from cbdsl.extend.driver import stopping_lines
    from cbdsl_ros2.injected_faults import Faults, read_fault
    from cbdsl_ros2.topic_server import RobotServer, simulated_robot

    if trace is not None:
        _require_writable(trace)
    document, urdf = read_robot(robot)
    document = with_control_rate(document, rate)
    set_up = read_stage(stage, document)
    injected = Faults([read_fault(text) for text in faults], seed)
    embodied = simulated_robot(backend, document, urdf, cameras)
    kept = None if stage is None else set_up
    server = RobotServer(document, urdf, embodied, interface, injected, stage=kept, report=report)
    moments = _Moments(seconds, stopped, keeps=trace is not None)
    pace = Pace(embodied.control_period, report, lambda: time.monotonic() - server.paused)
    try:
        drawn = server.reset(set_up, context, seed)
        report(_introduction(document, backend, set_up.name, drawn, interface))
        for line in stopping_lines(document, read_fitting(document, urdf)):
            report(line)
        # Setting up takes seconds, which count neither for the times of faults nor for the pace.
        injected.restart()
        pace.begin()
        # `Pace.note` always returns True, so that both functions are called.
        server.serve(lambda moment: pace.note() and moments.note(moment))
        report(pace.summary)
    finally:
        server.close()
        if trace is not None:
            # Also after an error, whose cause the motion may show.
            moments.write(trace, injected.begun)


def _require_writable(trace: Path) -> None:
    """Refuse a file for the motion before the robot is served, and not after it.

    Raises:
        UsageError: The path is a folder, or its folder does not exist.
    """
    from cbdsl.extend.backend import UsageError

    if trace.is_dir():
        raise UsageError(f"trace {trace}: this is a folder; name a file, such as motion.npz")
    if not trace.parent.is_dir():
        raise UsageError(f"trace {trace}: there is no folder {trace.parent}")


def _introduction(
    robot: RobotDocument, backend: str, stage: str, context: str, interface: str | None
) -> str:
    topics = [t for d in robot.drivers.values() for t in (d.states, d.commands) if t]
    where = interface or "loopback"
    return (
        f"serving {robot.name} ({backend}) on stage {stage}, context {context}; {where}, topics "
        f"{', '.join(topics)}"
    )


class Pace:
    """Real-time factor of a simulation: simulated time per wall time.

    Args:
        period: Simulated time of a tick, s.
        report: Function called once with a sentence, if a window is slower than real time.
        clock: Wall time, s.
    """

    def __init__(
        self,
        period: float,
        report: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._period, self._report, self._clock = period, report, clock
        self._has_reported = False
        self.begin()

    def begin(self) -> None:
        """Begin the simulation now."""
        self._ticks, self._began = 0, self._clock()
        # Ticks and time at the start of the present window.
        self._window = 0, self._began

    def note(self) -> bool:
        """Count a tick; return True."""
        self._ticks += 1
        ticks, began = self._window
        now = self._clock()
        # A window of seconds averages over the jitter of single ticks, such as rendered images.
        if now - began >= _WINDOW:
            self._window = self._ticks, now
            factor = (self._ticks - ticks) * self._period / (now - began)
            if factor < _SLOW and not self._has_reported:
                self._has_reported = True
                self._report(
                    f"slower than real time: real-time factor {factor:.2f} for {_WINDOW:.0f} s; "
                    "a program may be held. End other processes, or use ideal cameras"
                )
        return True

    @property
    def summary(self) -> str:
        """Simulated time and real-time factor since the start, as a sentence."""
        simulated, elapsed = self._ticks * self._period, self._clock() - self._began
        return f"served {simulated:.1f} s; real-time factor {simulated / max(elapsed, 1e-9):.3f}"


class _Moments:
    """Recorded motion of a served robot."""

    def __init__(self, seconds: float | None, stopped: Callable[[], bool], *, keeps: bool) -> None:
        self._until = None if seconds is None else time.monotonic() + seconds
        self._stopped, self._keeps = stopped, keeps
        self._moments: list[Moment] = []

    def note(self, moment: Moment) -> bool:
        """Keep a moment, and return whether the robot goes on."""
        # Without a trace, a service of days needs no more memory than one of seconds.
        if self._keeps:
            self._moments.append(moment)
        is_over = self._until is not None and time.monotonic() >= self._until
        return not (is_over or self._stopped())

    def write(self, path: Path, faults: dict[str, float]) -> None:
        """Write the motion, and the times at which faults began."""
        import numpy as np

        moments = self._moments
        # `np.savez` appends `.npz` to other names, but not to an open file.
        with path.open("wb") as file:
            np.savez(
                file,
                time=np.array([moment.time for moment in moments]),
                positions=np.array([moment.positions for moment in moments]),
                velocities=np.array([moment.velocities for moment in moments]),
                reference=np.array([moment.reference for moment in moments]),
                faults=np.array(list(faults.values())),
            )
