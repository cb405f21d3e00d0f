"""Watching: an episode in which a program shows a held ball to the cameras."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cbdsl.api.program import CheckedProgram
from cbdsl.api.sensing import EpisodeListeners, Runner
from cbdsl.extend.backend import Backend, Kinematics, RobotDocument, StageDocument
from cbdsl.extend.command import Journal
from cbdsl_calibration.estimate import CalibrationError
from cbdsl_calibration.hand_view import FINGERS, HandView, ViewRecorder
from cbdsl_calibration.hand_views import HandViews


def require_sight_and_touch(robot: RobotDocument) -> None:
    """Refuse robots that cannot see a ball or measure its position by touch.

    Raises:
        CalibrationError: If there is no camera, or no hand with enough load cells.
    """
    if not robot.cameras:
        raise CalibrationError(f"robot '{robot.name}' has no cameras to calibrate")
    if not any(len(cells) >= FINGERS for cells in robot.load_cells.values()):
        raise CalibrationError(
            f"robot '{robot.name}' has no hand with load cells on {FINGERS} fingers, by which it "
            "would feel where a ball is that its cameras see"
        )


def watch(
    robot: RobotDocument,
    kinematics: Kinematics,
    program: CheckedProgram,
    backend: Backend,
    stage: StageDocument,
    seed: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
    journal: Journal[HandViews] | None = None,
) -> list[HandView]:
    """Run the program once, and record the cameras' views of the ball.

    The journal's views count: the ball is handed over again, and shown for the remaining
    transitions of the program.

    Args:
        robot: Robot without corrections of its cameras.
        kinematics: Kinematics of the same robot.
        program: Program with the parameters ``hand``, the hand that holds the ball, and
            ``feature``, the ball's channel.
        backend: Backend to run it on.
        stage: Stage that hands the ball over.
        seed: Seed of all random numbers.
        progress: Listener for the numbers of completed and of all transitions, after each
            transition.
        journal: Journal that receives the views of each transition when it is over.

    Returns:
        All views, starting with the journal's.

    Raises:
        CalibrationError: If the program does not define hand and channel, or the hand has fewer
            than three load cells.
        BackendError, EpisodeError: Errors of ``Runner.run``.
    """
    hand, channel = _parameter(program, "hand"), _parameter(program, "feature")
    if len(robot.load_cells.get(hand, {})) < FINGERS:
        hands = [name for name, cells in robot.load_cells.items() if len(cells) >= FINGERS]
        raise CalibrationError.unknown(f"hand with load cells on {FINGERS} fingers", hand, hands)
    rows = [] if journal is None else list(journal.rows)
    passed, hold = len(rows), 1 + rows[-1].hold if rows else 0
    left = program.transitions - passed
    runner = Runner(robot, kinematics, program._replace(transitions=max(left, 1)), backend)
    if channel not in runner.signals.vision.channels:
        raise CalibrationError(
            f"program '{program.name}' does not look for '{channel}', its parameter 'feature'"
        )
    before = [view for row in rows for view in row.views]
    if passed >= program.transitions:
        return before
    recorder, kept = ViewRecorder(robot, kinematics, hand, channel, hold), 0

    def count(_: object) -> None:
        nonlocal passed
        passed += 1
        keep()
        progress(passed, program.transitions)

    def keep() -> None:
        nonlocal kept
        if journal is not None:
            journal.append(HandViews(hold, recorder.views[kept:]))
        kept = len(recorder.views)

    listeners = EpisodeListeners(on_transition=count, on_tick=recorder.note)
    runner.run(stage, _seed(seed, hold), observer=listeners)
    if not recorder.touched and not before:
        raise CalibrationError(
            f"in program '{program.name}' on stage '{stage.name}' the fingers of {hand} never all "
            "felt a ball; hand one over, and let the program close the fingers on it"
        )
    return before + recorder.views


def _seed(seed: int, hold: int) -> int:
    """Return the seed of a hold; in another hold the robot shows the ball in other postures."""
    return seed if hold == 0 else int(np.random.SeedSequence((seed, hold)).generate_state(1)[0])


def _parameter(program: CheckedProgram, name: str) -> str:
    if name not in program.parameters:
        raise CalibrationError(
            f"program '{program.name}' has no parameter '{name}'; one that shows a ball says by "
            "'hand' which hand holds it and by 'feature' in which channel it is seen"
        )
    return program.parameters[name]
