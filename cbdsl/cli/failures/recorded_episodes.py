"""Episodes that are recorded to be explained, and their first causes as JSON data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cbdsl.cli.episodes.recorder import Recorder
from cbdsl.cli.episodes.simulation import simulation
from cbdsl.diagnostics.errors import UsageError
from cbdsl.runtime.recording_folder import RecordingFolder

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.reporting.why.diagnosis import Diagnosis
    from cbdsl.reporting.why.history import FailureCause, History
    from cbdsl.runtime.episode_result import EpisodeResult


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
        from cbdsl.backends.backend import AttendedBackend
        from cbdsl.runtime.episode import EpisodeError, Runner
        from cbdsl.runtime.episode_observer import EpisodeListeners, EpisodeObservers

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
    from cbdsl.reporting.recorded import read_recording
    from cbdsl.reporting.why.diagnosis import diagnose
    from cbdsl.reporting.why.history import History

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
    }


def _cause(history: History, cause: FailureCause) -> dict[str, Any]:
    return {**cause._asdict(), "time": round(float(history.time[cause.tick]), 4)}
