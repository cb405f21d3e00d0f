"""Packages as an installer leaves them: modules and metadata in a folder of ``sys.path``."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import invalidate_caches
from pathlib import Path
from typing import Any

from cbdsl.backends.backend import BACKENDS
from cbdsl.cli.commands import COMMANDS
from cbdsl.documents.kinds import KINDS
from cbdsl.learning.learner import LEARNERS
from cbdsl.reporting.diagnoses import DIAGNOSES
from cbdsl.reporting.export_format import EXPORTS
from cbdsl.robot.driver_kind import DRIVERS
from cbdsl.robot.source_kind import SOURCES
from cbdsl.scaffold.model_format import MODEL_FORMATS
from cbdsl.training.side_by_side import CLUSTERS
from cbdsl.types.modifier import MODIFIERS
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.registry import Registry

REGISTRIES: tuple[Registry[Any], ...] = (
    KINDS,
    LEARNERS,
    BACKENDS,
    POTENTIALS.registry,
    SOURCES,
    MODIFIERS,
    DRIVERS,
    COMMANDS,
    EXPORTS,
    CLUSTERS,
    DIAGNOSES,
    MODEL_FORMATS,
)


def refresh() -> None:
    """Let all registries search the installed packages again."""
    for registry in REGISTRIES:
        registry.refresh()


def write_package(
    folder: Path, name: str, points: Mapping[str, Mapping[str, str]], **modules: str
) -> None:
    """Write a distribution.

    Args:
        folder: Folder on ``sys.path``.
        name: Name of the distribution, whose version is 1.0.
        points: Entry points, by group and name.
        modules: Text by module.
    """
    metadata = folder / f"{name.replace('-', '_')}-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = [
        line
        for group, entries in points.items()
        for line in (f"[{group}]", *(f"{key} = {value}" for key, value in entries.items()))
    ]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")
    for module, text in modules.items():
        (folder / f"{module}.py").write_text(text)


@contextmanager
def on_path(folder: Path) -> Iterator[None]:
    """Have a folder's packages importable, and forget them afterwards."""
    before = set(sys.modules)
    sys.path.insert(0, str(folder))
    invalidate_caches()
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        for name in set(sys.modules) - before:
            if str(getattr(sys.modules[name], "__file__", None) or "").startswith(str(folder)):
                del sys.modules[name]


def installed(project: Path, folder: Path) -> Path:
    """Have a project's modules and the metadata of its ``pyproject.toml`` in a folder."""
    table = tomllib.loads((project / "pyproject.toml").read_text("utf-8"))["project"]
    write_package(folder, table["name"], table["entry-points"])
    (folder / "demo").symlink_to(project / "demo", target_is_directory=True)
    return folder
