"""Warnings of plug-ins that cannot be used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cbdsl.types.registry import Registry


def warn_of_faults(*registries: Registry[Any]) -> None:
    """Name the faulty plug-ins of registries, with their packages, on the standard error."""
    from cbdsl.cli.output.terminal import print_problem

    for registry in registries:
        for fault in registry.faults():
            print_problem(f"warning: {fault}")
