"""Recorder of ``cb run``: each episode into a folder, those that were interrupted or failed too."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.run_request import RunRequest
    from cbdsl.backends.backend import Backend
    from cbdsl.runtime.episode import EpisodeResult
    from cbdsl.runtime.recording import Recording


class Recorder:
    """Recordings of the episodes of one command.

    Args:
        folder: where they are kept.
        request: what runs.
        backend: where it runs.
        seeds: of the episodes.
        overwrite: whether recordings that are there may be replaced.
        tells: whether each file is printed.

    Raises:
        UsageError: the folder cannot keep them; found out before the episodes, not after.
    """

    def __init__(
        self,
        folder: Path,
        request: RunRequest,
        backend: Backend,
        seeds: Sequence[int],
        *,
        overwrite: bool,
        tells: bool,
    ) -> None:
        from cbdsl.runtime.recording_folder import RecordingFolder

        self._folder = RecordingFolder(folder, overwrite=overwrite)
        self._request, self._backend, self._tells = request, backend, tells
        with self._named_problems():
            self._folder.require_ready(seeds)

    @contextmanager
    def episode(self, seed: int, ended: Sequence[EpisodeResult]) -> Iterator[Recording]:
        """Recording to fill with an episode, which no other process may record meanwhile.

        It is written on the way out, unless it has not a single tick.

        Args:
            seed: of the episode.
            ended: its result, once it has ended in whatever way.

        Raises:
            UsageError: another process records it, or it cannot be written.
        """
        from cbdsl.backends.staging.world_state import GroundTruthProvider
        from cbdsl.runtime.recording import Recording

        backend, request = self._backend, self._request
        # What a backend knows of its world is in the recording only: people look at that.
        scenery = (lambda: backend.truth) if isinstance(backend, GroundTruthProvider) else None
        recording = Recording(request.program, request.robot, request.urdf, scenery)
        with ExitStack() as claimed:
            with self._named_problems():
                claimed.enter_context(self._folder.claim(seed))
            try:
                yield recording
            finally:
                if ended and recording.ticks:
                    self._write(recording, ended[0])

    def _write(self, recording: Recording, result: EpisodeResult) -> None:
        with self._named_problems():
            file = recording.write(self._folder.path, result)
        if self._tells:
            print(f"  recorded in {file}", flush=True)

    @contextmanager
    def _named_problems(self) -> Iterator[None]:
        from cbdsl.errors.errors import UsageError
        from cbdsl.errors.reason import reason

        try:
            yield
        except OSError as error:
            where = error.filename or self._folder.path
            raise UsageError(f"--record {where}: {reason(error)}") from error
