"""Episodes that are recorded to be explained, and their first causes as JSON data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cbdsl import RunRequest, UsageError
from cbdsl.extend.command import Recorder, RecordingFolder, simulation

if TYPE_CHECKING:
    from cbdsl import EpisodeResult
    from cbdsl_why.diagnosis import Diagnosis
    from cbdsl_why.history import FailureCause, History


def recorded_episodes(
    request: RunRequest,
    backend: str,
    cameras: str | None,
    seeds: Sequence[int],
    folder: Path,
    *,
    context: str | None = None,
    gui: bool = False,
) -> Iterator[Path]:
    """Run an episode for each seed, and yield its recording.

    Args:
        request: Program and stage.
        backend: Name of the backend.
        cameras: Kind of cameras; the backend's own if ``None``.
        seeds: Seeds of the episodes.
        folder: Folder of the recordings.
        context: Context of the stage; drawn if ``None``.
        gui: True to open the simulator's window.

    Raises:
        UsageError: The backend is unknown, or a real robot.
    """
    with simulation(request, backend, gui=gui, cameras=cameras) as (embodied, kinematics):
        from cbdsl.extend.backend import AttendedBackend
        from cbdsl.extend.command import EpisodeError, EpisodeListeners, EpisodeObservers, Runner

        if isinstance(embodied, AttendedBackend):
            raise UsageError("on a real robot, cb run --record FOLDER and cb why FOLDER")
        runner = Runner(request.robot, kinematics, request.program, embodied)
        recorder = Recorder(folder, request, embodied, seeds, overwrite=True, prints=False)
        for seed in seeds:
            ended: list[EpisodeResult] = []
            # An episode that cannot go on is recorded up to its error.
            with suppress(EpisodeError), recorder.episode(seed, ended) as recording:
                observer = EpisodeObservers(EpisodeListeners(on_end=ended.append), recording)
                runner.run(request.stage, seed, context, observer)
            yield RecordingFolder(folder).files(seed)[1]


def diagnosed(file: Path) -> tuple[History, Diagnosis]:
    """Return the history of a recording, and its diagnosis."""
    from cbdsl.extend.diagnosis import read_recording
    from cbdsl_why.diagnosis import diagnose
    from cbdsl_why.history import History

    history = History(read_recording(file))
    return history, diagnose(history)


def diagnosis_row(history: History, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the diagnosis of an episode as JSON data."""
    result = history.result
    return {
        "program": result["program"],
        "stage": result["stage"],
        "seed": result["seed"],
        "failed": diagnosis.failed,
        "ending": result["ending"],
        "cause": None if diagnosis.cause is None else _cause(history, diagnosis.cause),
        "others": [_cause(history, each) for each in diagnosis.others],
        "ruled_out": diagnosis.ruled_out,
        "missing": diagnosis.missing,
        "doubts": diagnosis.doubts,
    }


def _cause(history: History, cause: FailureCause) -> dict[str, Any]:
    return {**cause._asdict(), "time": round(float(history.time[cause.tick]), 4)}
