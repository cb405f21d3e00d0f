"""Jobs: commands of cb that run beside the server, and can be cancelled."""

from __future__ import annotations

import asyncio
import signal
import sys
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mcp.server.mcpserver.exceptions import ToolError

# Number of bytes of its output that a report of a job holds.
_BYTES = 60_000
# Time for a job to end after an interrupt, s.
_PATIENCE = 10.0
# With -P, Python imports nothing from the folder, whose files may be a client's.
_COMMAND = (sys.executable, "-P", "-c", "from cbdsl.cli.main import main; main()")


class Job:
    """Command of cb in a folder.

    Args:
        words: Words of the command.
        process: Process that runs it.

    Attributes:
        words: Words of the command.
        is_cancelled: True if the client cancelled it.
    """

    def __init__(self, words: Sequence[str], process: Process) -> None:
        self.words, self._process = tuple(words), process
        self.is_cancelled = False
        self._output = bytearray()
        self._dropped = 0
        self._reader = asyncio.create_task(self._read())

    @classmethod
    async def start(cls, words: Sequence[str], folder: Path) -> Job:
        """Start a command of cb in a folder."""
        process = await asyncio.create_subprocess_exec(
            *_COMMAND,
            *words,
            cwd=folder,
            stdin=DEVNULL,
            stdout=PIPE,
            stderr=asyncio.subprocess.STDOUT,
        )
        return cls(words, process)

    async def _read(self) -> None:
        assert self._process.stdout is not None
        while part := await self._process.stdout.read(_BYTES):
            self._output += part
            # The end of a long output is worth more than its beginning.
            beyond = max(len(self._output) - _BYTES, 0)
            self._dropped += beyond
            del self._output[:beyond]
        await self._process.wait()

    async def wait(self, seconds: float) -> None:
        """Wait until the job has ended, for at most some seconds."""
        await asyncio.wait([self._reader], timeout=seconds)

    async def cancel(self) -> None:
        """Interrupt the job as Ctrl-C does, so that finished recordings stay; kill a deaf one."""
        if self._reader.done():
            return
        self.is_cancelled = True
        self._process.send_signal(signal.SIGINT)
        await self.wait(_PATIENCE)
        if not self._reader.done():
            self._process.kill()
            await self._reader

    @property
    def report(self) -> dict[str, Any]:
        """State, exit code and end of the output."""
        state = "done" if self._reader.done() else "running"
        return {
            "command": "cb " + " ".join(self.words),
            "state": "cancelled" if self.is_cancelled and state == "done" else state,
            "exit_code": self._process.returncode,
            "output": self._output.decode("utf-8", errors="replace").rstrip("\n"),
            "dropped_bytes": self._dropped,
        }


class Jobs:
    """Jobs of a server by number.

    Args:
        folder: Folder in which all commands run.
        most: Largest number of jobs that run at the same time.
    """

    def __init__(self, folder: Path, most: int = 4) -> None:
        self.folder, self._most = folder, most
        self._jobs: dict[int, Job] = {}

    async def start(self, words: Sequence[str]) -> int:
        """Start a job, and return its number.

        Raises:
            ToolError: Too many jobs run.
        """
        running = [n for n, job in self._jobs.items() if job.report["state"] == "running"]
        if len(running) >= self._most:
            raise ToolError(f"{self._most} jobs run already ({running}): wait for one or cancel it")
        number = len(self._jobs) + 1
        self._jobs[number] = await Job.start(words, self.folder)
        return number

    def job(self, number: int) -> Job:
        """Return a job.

        Raises:
            ToolError: There is no such job.
        """
        if number not in self._jobs:
            raise ToolError(f"no job {number} (known: {', '.join(map(str, self._jobs)) or 'none'})")
        return self._jobs[number]

    async def close(self) -> None:
        """Cancel all jobs."""
        for job in self._jobs.values():
            await job.cancel()
