"""Parts of commands, for the commands of other packages: options, progress and output."""

from __future__ import annotations

from cbdsl.backends.quiet import quiet_stderr
from cbdsl.cli.arguments.options import Cameras, Json
from cbdsl.cli.arguments.workers import require_workers
from cbdsl.cli.output.progress import Progress
from cbdsl.cli.output.terminal import print_json, print_problem, print_table
from cbdsl.cli.process.native_output import shown_on_failure
from cbdsl.cli.process.termination import termination_interrupts
from cbdsl.diagnostics.reason import reason

__all__ = [
    "Cameras",
    "Json",
    "Progress",
    "print_json",
    "print_problem",
    "print_table",
    "quiet_stderr",
    "reason",
    "require_workers",
    "shown_on_failure",
    "termination_interrupts",
]
