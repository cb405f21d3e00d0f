"""Commands of ``cb``, for the entry-point group ``cbdsl.commands``.

An entry is a function with Typer's annotations, or a ``typer.Typer``; its docstring is its help. An
entry ``drive.NAME`` or ``export.NAME`` adds a command to ``cb drive`` or ``cb export``.
``UsageError`` ends a command with its message and exit code 2, ``DiagnosticsError`` with its
diagnostics and exit code 1. The names below are common options, progress, output, pages, their
servers and journals.

``declaration`` and ``verb`` derive a verb's signature and docstring from a class of its inputs;
``grouped`` derives the options of its command, ``call_text`` and ``command_text`` the texts that
repeat it. The contract test is ``cbdsl.extend.contract.test_command``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.api.requests.declaration import (
        BACKEND,
        CAMERAS,
        SEED,
        call_text,
        declaration,
        engine_of,
        given,
        verb,
    )
    from cbdsl.api.requests.run_request import read_program
    from cbdsl.backends.engines import default_engine
    from cbdsl.backends.quiet import quiet_stderr
    from cbdsl.cli.arguments.assignments import read_assignments
    from cbdsl.cli.arguments.command_text import command_text
    from cbdsl.cli.arguments.option_groups import grouped
    from cbdsl.cli.arguments.options import (
        Above,
        BackendName,
        Cameras,
        Json,
        Open,
        Policy,
        Program,
        Rate,
        With,
    )
    from cbdsl.cli.arguments.run_options import RunOptions
    from cbdsl.cli.arguments.workers import require_workers
    from cbdsl.cli.command_group import CommandGroup
    from cbdsl.cli.commands import commands_of
    from cbdsl.cli.episodes.attendance import Interface, TerminalPerson
    from cbdsl.cli.episodes.pages import open_page, require_room, write_page
    from cbdsl.cli.episodes.recorder import Recorder
    from cbdsl.cli.episodes.simulation import needing_simulation, simulation
    from cbdsl.cli.output.compilation import told_of_compilation
    from cbdsl.cli.output.progress import Progress
    from cbdsl.cli.output.terminal import print_json, print_line, print_problem, print_table
    from cbdsl.cli.process.native_output import shown_on_failure
    from cbdsl.cli.process.termination import stop_requests, termination_interrupts
    from cbdsl.cli.show.meta_catalog import read_meta_catalog
    from cbdsl.diagnostics.counting import count
    from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
    from cbdsl.diagnostics.reason import reason
    from cbdsl.reporting.bundle import Bundle
    from cbdsl.reporting.live.feed import Feed
    from cbdsl.reporting.live.page_server import LiveServer, RequestError
    from cbdsl.reporting.page import page
    from cbdsl.reporting.template import filled
    from cbdsl.reporting.text.meta_catalog_text import stack_command
    from cbdsl.runtime.episode import EpisodeError, Runner
    from cbdsl.runtime.episode_observer import EpisodeListeners, EpisodeObservers
    from cbdsl.runtime.recording_folder import RecordingFolder
    from cbdsl.storage.journal import MOST_BYTES, Journal, RowForm, rows_of

__all__ = [
    "BACKEND", "CAMERAS", "MOST_BYTES", "SEED", "Above", "BackendName", "Bundle", "Cameras",
    "CommandGroup", "DiagnosticsError", "EpisodeError", "EpisodeListeners", "EpisodeObservers",
    "Feed", "Interface", "Journal", "Json", "LiveServer", "Open", "Policy", "Program", "Progress",
    "Rate", "Recorder", "RecordingFolder", "RequestError", "RowForm", "RunOptions", "Runner",
    "TerminalPerson", "UsageError", "With",
    "call_text", "command_text", "commands_of", "count", "declaration", "default_engine",
    "engine_of", "filled", "given", "grouped", "needing_simulation", "open_page", "page",
    "print_json", "print_line", "print_problem", "print_table", "quiet_stderr", "read_assignments",
    "read_meta_catalog", "read_program", "reason", "require_room",
    "require_workers", "rows_of", "shown_on_failure", "simulation", "stack_command",
    "stop_requests", "termination_interrupts", "told_of_compilation", "verb", "write_page",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
