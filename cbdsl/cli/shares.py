"""Shares of an experiment that learns: carried out side by side, and told of."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.reproduction.experiment import Experiment, Settings
    from cbdsl.reproduction.share import Share


def carry_out_shares(experiment: Experiment, settings: Settings, workers: int) -> None:
    """Run all episodes of an experiment in other processes; its folder keeps them.

    Args:
        experiment: in which the robot learns.
        settings: of it.
        workers: how many processes.

    Raises:
        UsageError: a share could not be carried out; what is over is kept.
    """
    from cbdsl.backends.backend import find_backend
    from cbdsl.cli.quiet import quiet_stderr
    from cbdsl.errors.errors import UsageError
    from cbdsl.reproduction.share import shared_out

    with quiet_stderr():
        find_backend(settings.backend)
    try:
        from cbdsl.training.cluster import carry_out_all
    except ModuleNotFoundError as error:
        raise UsageError(
            f"--workers needs {error.name}, which is not installed: pip install 'cbdsl[learn]'"
        ) from error
    with shared_out(experiment, settings) as shares:
        supervision = _Supervision(shares, settings)
        if len(shares) > 1:  # with a single one nothing can be done side by side
            carry_out_all(shares, min(workers, len(shares)), None, supervision)
    supervision.conclude()


class _Supervision:
    """Tells how far the shares are that run elsewhere; see ``Supervisor``.

    Args:
        shares: all of them.
        settings: who watches.
    """

    def __init__(self, shares: Sequence[Share], settings: Settings) -> None:
        self._shares, self._settings = shares, settings
        self._failures: list[Exception] = []

    def look(self, workers: int) -> None:
        """See ``Supervisor.look``."""
        told = [share.told() for share in self._shares]
        # One that has not begun has as many episodes as any other.
        total = max(total for _, total in told)
        if total:
            self._settings.progress(sum(done for done, _ in told), total * len(told))

    def done(self, share: Share, files: Sequence[Path], /) -> None:
        """See ``Supervisor.done``."""

    def failed(self, share: Share, error: Exception, /) -> None:
        """See ``Supervisor.failed``."""
        self._failures.append(error)

    def conclude(self) -> None:
        """At the end, say what went wrong first.

        Raises:
            Exception: what a share raised.
        """
        if self._failures:
            raise self._failures[0]
