"""Playground: a page on which a program is edited, checked, drawn and run."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import webbrowser
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from time import sleep
from typing import Any

from cbdsl.extend.command import (
    Feed,
    LiveServer,
    RequestError,
    filled,
    print_line,
    stop_requests,
)
from cbdsl.extend.document import NAME_PATTERN, Library, ProgramDocument
from cbdsl_report.markup import ASSETS

_CB = (sys.executable, "-c", "from cbdsl.cli.main import main; main()")
# Longest time of a check and of a run, s.
_CHECK, _RUN = 30.0, 180.0
_PERIOD = 0.1
_STYLES = ("page.css", ASSETS / "playground.css")
_SCRIPTS = ("page.js", "data.js", "asking.js", ASSETS / "playground.js")


def serve_playground(program: str, port: int, *, opens: bool) -> None:
    """Serve the page of a program until Ctrl-C.

    Args:
        program: File or name of the program.
        port: Port of the page; any free port for 0.
        opens: True if the page is shown in the browser.
    """
    library = Library()
    text = library.text(library.locate(ProgramDocument, program))
    requests = PlaygroundRequests()
    server = LiveServer(Feed(), lambda token: playground_page(text, token), requests, port)
    with stop_requests() as stopped:
        try:
            print_line(f"playground at {server.url}; Ctrl-C ends it")
            if opens:
                webbrowser.open(server.url)
            while not stopped():
                sleep(_PERIOD)
        finally:
            requests.close()
            server.close()


def playground_page(text: str, token: str) -> str:
    """Return the page with a program; its results come from its server.

    Args:
        text: Text of the program.
        token: Token that requests have to contain.
    """
    from cbdsl.extend.command import Bundle  # imports numpy, which a browser does without

    data = Bundle().text({"text": text, "token": token})
    template = ASSETS / "playground.html"
    return filled(template, "playground", _STYLES, _SCRIPTS, data, {}, connects=True)


class PlaygroundRequests:
    """Requests of the page, each by the commands that users type, in a process of its own."""

    def __init__(self) -> None:
        self._turn = Lock()
        self._process: subprocess.Popen[str] | None = None

    def __call__(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return diagnostics of a program and a picture of its steps, or the output of its run.

        Args:
            request: ``text`` of the program, and ``seed`` for a run.

        Raises:
            RequestError: Another request is executed, or this one took too long.
        """
        text, seed = str(request["text"]), request.get("seed")
        if not self._turn.acquire(blocking=False):
            raise RequestError("the previous request is still being executed")
        try:
            with TemporaryDirectory() as folder:
                file = Path(folder) / f"{_name(text)}.yaml"
                file.write_bytes(text.encode("utf-8", "replace"))
                return self._check(file) if seed is None else self._run(file, int(seed))
        finally:
            self._turn.release()

    def _check(self, file: Path) -> Mapping[str, Any]:
        report = json.loads(self.output(_CHECK, "validate", "--json", str(file)))
        words = ("show", "program", file, "--format", "svg")
        steps = "" if report["errors"] else self.output(_CHECK, *words)
        return {"findings": report["findings"], "steps": steps}

    def _run(self, file: Path, seed: int) -> Mapping[str, Any]:
        words = ("run", str(file), "--backend", "kinematic", "--seed", str(seed))
        return {"output": self.output(_RUN, *words, errors=subprocess.STDOUT)}

    def output(self, seconds: float, *words: str | Path, errors: int = subprocess.DEVNULL) -> str:
        """Return the output of a command; by default without warnings, which are no JSON."""
        with subprocess.Popen(
            [*_CB, *map(str, words)], text=True, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=errors,
        ) as self._process:  # fmt: skip
            try:
                return self._process.communicate(timeout=seconds)[0]
            except subprocess.TimeoutExpired:
                self._process.kill()
                raise RequestError(f"it took longer than {seconds:g} s") from None

    def close(self) -> None:
        """End the command that runs."""
        if self._process is not None:
            self._process.kill()


def _name(text: str) -> str:
    """Return the name of a document, which is that of its file."""
    match = re.search(r"(?m)^name: *(\w+) *$", text)
    return match[1] if match and re.search(NAME_PATTERN, match[1]) else "playground"
