"""Recorder of ``cb run``: all episodes in a folder, including interrupted and failed ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.cli.output.terminal import print_line
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.reason import reason
from cbdsl.runtime.recording_folder import RecordingFolder

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.backends.backend import Backend
    from cbdsl.reporting.automaton_text import AutomatonData
    from cbdsl.runtime.episode_result import EpisodeResult
    from cbdsl.runtime.recording import Recording


class Recorder:
    """Recordings of the episodes of one command.

    Args:
        folder: Folder of the recordings.
        request: Program and stage.
        backend: Backend of the run.
        seeds: Seeds of the episodes.
        overwrite: True if existing recordings may be replaced.
        prints: True if each file is printed.

    Raises:
        UsageError: The folder cannot hold the recordings; checked before the episodes.
    """

    def __init__(
        self,
        folder: Path,
        request: RunRequest,
        backend: Backend,
        seeds: Sequence[int],
        *,
        overwrite: bool,
        prints: bool,
    ) -> None:

        self._folder = RecordingFolder(folder, overwrite=overwrite)
        self._request, self._backend, self._prints = request, backend, prints
        with self._named_problems():
            self._folder.require_ready(seeds)

    @cached_property
    def _automata(self) -> Mapping[str, AutomatonData]:
        from cbdsl.reporting.automaton_text import automata

        return automata(self._request.program)

    @contextmanager
    def episode(self, seed: int, ended: Sequence[EpisodeResult]) -> Iterator[Recording]:
        """Yield the recording of an episode, locked against other processes.

        The recording is written at the exit of the context, unless it is without ticks.

        Args:
            seed: Seed of the episode.
            ended: Result of the episode; empty until its end.

        Raises:
            UsageError: Another process records the episode, or it cannot be written.
        """
        from cbdsl.backends.staging.world_state import GroundTruthProvider
        from cbdsl.runtime.recording import Recording

        backend, request = self._backend, self._request
        # The backend's ground truth is only in the recording, for display.
        scenery = (lambda: backend.truth) if isinstance(backend, GroundTruthProvider) else None
        digest = request.digest
        source = str(request.program_file.resolve()), digest.sha256, digest.shared
        recording = Recording(
            request.program, request.robot, request.urdf, scenery, source, self._automata
        )
        # The inner context names problems of the claim alone; errors of the episode keep their
        # words.
        with ExitStack() as claimed:
            with self._named_problems():
                claimed.enter_context(self._folder.claim(seed))
            try:
                yield recording
            finally:
                # An episode that fails before its first tick has nothing to replay.
                if ended and recording.ticks:
                    self._write(recording, ended[0])

    def _write(self, recording: Recording, result: EpisodeResult) -> None:
        with self._named_problems():
            file = recording.write(self._folder.path, result)
        if self._prints:
            print_line(f"  recorded in {file}")

    @contextmanager
    def _named_problems(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            where = error.filename or self._folder.path
            raise UsageError(f"--record {where}: {reason(error)}") from error
