"""Distributions that share an import name, and overwrite each other's files."""

from __future__ import annotations

import csv
import re
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import NamedTuple

from cbdsl.diagnostics.errors import UsageError


class _Shared(NamedTuple):
    """Module whose files several distributions provide.

    Attributes:
        distributions: Names of the distributions.
        extra: Extra of cbdsl that installs the right ones.
        alternatives: True if only one of them may be installed; else all have one version.
        major: Supported major version, 0 for any.
    """

    distributions: tuple[str, ...]
    extra: str
    alternatives: bool = False
    major: int = 0


_SHARED = {
    "pybullet": _Shared(("pybullet", "pybullet-arm64"), "bullet", alternatives=True),
    "mujoco": _Shared(("mujoco", "mujoco-core", "mujoco-studio"), "mujoco", major=4),
}


def require_unmixed(module: str) -> None:
    """Check that the files of a module belong together.

    Args:
        module: Import name of a top-level module.

    Raises:
        UsageError: Distributions have overwritten each other's files, files are missing, or the
            version is not supported.
    """
    shared = _SHARED.get(module)
    if shared is None:
        return
    candidates = map(_installed, shared.distributions)
    installed = [candidate for candidate in candidates if candidate is not None]
    named = " and ".join(f"{each.name} {each.version}" for each in installed)
    again = (
        f"pip uninstall -y {' '.join(shared.distributions)}; pip install 'cbdsl[{shared.extra}]'"
    )
    versions = {each.version for each in installed}
    # For example both pybullet and pybullet-arm64, or mujoco and mujoco-core of different versions.
    if len(installed if shared.alternatives else versions) > 1:
        raise UsageError(f"{named} overwrite each other's files of {module}; try: {again}")
    if any(_is_damaged(each, module) for each in installed):
        raise UsageError(f"files of {named} are missing or of another version; try: {again}")
    if shared.major and any(int(version.split(".")[0]) != shared.major for version in versions):
        raise UsageError(f"{named} is installed; cbdsl needs version {shared.major}; try: {again}")


def _installed(name: str) -> Distribution | None:
    try:
        return distribution(name)
    except PackageNotFoundError:
        return None


def _is_damaged(owner: Distribution, module: str) -> bool:
    """Return whether a recorded file of a module is missing or has another size."""
    # Distribution.files leaves out missing files.
    for name, _, size in csv.reader((owner.read_text("RECORD") or "").splitlines()):
        if re.split(r"[./]", name)[0] != module or "__pycache__" in name or not size:
            continue
        path = Path(str(owner.locate_file(name)))
        if not path.is_file() or path.stat().st_size != int(size):
            return True
    return False
