"""Answers to requests of the playground, by commands that run in this process."""

from __future__ import annotations

import json
import sys
from contextlib import redirect_stderr, redirect_stdout, suppress
from io import StringIO
from pathlib import Path
from unittest.mock import patch

from cbdsl.cli.main import main
from cbdsl.extend.command import RequestError
from cbdsl_report.playground import PlaygroundRequests


class BrowserRequests(PlaygroundRequests):
    """Requests of a page without a server: a browser has no processes."""

    def output(self, seconds: float, *words: str | Path, errors: int = 0) -> str:
        """Return the output of a command, without its warnings."""
        printed = StringIO()
        with (
            redirect_stdout(printed),
            redirect_stderr(StringIO()),
            patch.object(sys, "argv", ["cb", *map(str, words)]),
            suppress(SystemExit),
        ):
            main()
        return printed.getvalue()


_requests = BrowserRequests()


def answer(request: str) -> str:
    """Return the answer to a request, both as JSON."""
    try:
        return json.dumps(_requests(json.loads(request)))
    except RequestError as error:
        return json.dumps({"problem": str(error)})
