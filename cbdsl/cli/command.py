"""Parts of commands, for the commands of other packages: options, progress and output."""

from __future__ import annotations

from cbdsl.backends.quiet import quiet_stderr
from cbdsl.cli.native_output import shown_on_failure
from cbdsl.cli.options import Cameras, Json
from cbdsl.cli.progress import Progress
from cbdsl.cli.terminal import print_json, print_problem, print_table
from cbdsl.cli.termination import termination_interrupts
from cbdsl.cli.workers import require_workers
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
