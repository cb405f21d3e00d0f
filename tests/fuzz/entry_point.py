"""Entry points: the functions of cbdsl that read text from arbitrary sources."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from typing import NamedTuple


class EntryPoint(NamedTuple):
    """Entry point, as a fuzzer and the tests call it.

    Attributes:
        read: Function that reads bytes; every exception that it raises is a fault.
        seeds: Function that returns well or nearly well formed inputs to begin with.
    """

    read: Callable[[bytes], None]
    seeds: Callable[[], Iterator[bytes]]


#: Modules of entry points by their names; each has a mapping ``ENTRY_POINTS``.
MODULES: Mapping[str, str] = {
    **dict.fromkeys(
        (
            *("program", "stage", "robot", "policy", "schema", "catalog", "meta_catalog", "model"),
            "calibration",
            "relations",
            "shared",
        ),
        "documents",
    ),
    **dict.fromkeys(("composition", "quantity", "scalar", "pattern", "layout"), "language"),
    **dict.fromkeys(("urdf", "srdf", "xacro", "xacro_expression", "mjcf", "mesh"), "robot_models"),
    **dict.fromkeys(("journal", "exploration_journal", "recording", "arrays"), "kept_files"),
    **dict.fromkeys(("edits", "page_request", "command_line"), "clients"),
}


def entry_point(name: str) -> EntryPoint:
    """Return the entry point of a name; import its module now."""
    module = import_module(f"tests.fuzz.{MODULES[name]}")
    found: EntryPoint = module.ENTRY_POINTS[name]
    return found
