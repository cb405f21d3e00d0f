"""``cb`` on a disk so slow that most of the time goes into half-written files."""

from __future__ import annotations

import io
import os
import time
from typing import Any

from cbdsl.cli.main import main

PAUSE = 0.004
"""Between two parts of what is written, s."""


class SlowFile:
    """File that writes only a part of the given data at a time, which is then on the disk."""

    def __init__(self, file: Any) -> None:
        self._file = file

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def __enter__(self) -> SlowFile:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()

    def write(self, data: Any) -> int:
        """Write the first part of the data; write buffered data whole, in many parts."""
        part = len(data) // 4 + 1
        written = self._file.write(data[:part])
        self._file.flush()
        time.sleep(PAUSE)
        if not isinstance(self._file, io.RawIOBase) and data[part:]:
            written += self.write(data[part:])
        return int(written)


def slow_down() -> None:
    """Have every file that is opened by its descriptor written slowly."""
    fdopen, replace = os.fdopen, os.replace

    def late(*arguments: Any) -> None:
        time.sleep(PAUSE)
        replace(*arguments)

    os.fdopen = lambda *given, **named: SlowFile(fdopen(*given, **named))  # type: ignore[task]
    os.replace = late  # type: ignore[task]


if __name__ == "__main__":
    slow_down()
    main()
