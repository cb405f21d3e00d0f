"""Distributions that overwrite each other's files, and the remedy."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from cbdsl.backends.backend import BackendError, find_backend
from cbdsl.backends.distributions import require_unmixed
from cbdsl.diagnostics.errors import UsageError


def install(folder: Path, name: str, version: str, files: Mapping[str, str]) -> None:
    """Write a distribution with its files, which replace those of the same path."""
    information = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    information.mkdir()
    (information / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n", encoding="utf-8"
    )
    for path, text in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")
    rows = [f"{path},,{len(text)}" for path, text in files.items()]
    (information / "RECORD").write_text("\n".join(rows) + "\n", encoding="utf-8")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the only folder with distributions, beside the standard library."""
    standard = [entry for entry in sys.path if entry and "site-packages" not in entry]
    monkeypatch.setattr(sys, "path", [str(tmp_path), *standard])
    return tmp_path


@pytest.mark.parametrize(
    ("module", "first", "second"),
    [
        ("mujoco", ("mujoco-core", "4.0.1"), ("mujoco", "3.17.0")),
        ("mujoco", ("mujoco", "4.0.0"), ("mujoco-core", "4.0.1")),
        ("pybullet", ("pybullet", "3.2.7"), ("pybullet-arm64", "3.2.8")),
        ("pybullet", ("pybullet", "3.2.8"), ("pybullet-arm64", "3.2.8")),
    ],
)
def test_require_unmixed_names_both_distributions_and_the_remedy(
    folder: Path, module: str, first: tuple[str, str], second: tuple[str, str]
) -> None:
    for name, version in (first, second):
        install(folder, name, version, {f"{module}/__init__.py": version})
    with pytest.raises(UsageError) as raised:
        require_unmixed(module)
    message = str(raised.value)
    assert all(" ".join(each) in message for each in (first, second))
    assert f"pip uninstall -y {module}" in message and "pip install 'cbdsl[" in message
    assert "\n" not in message


def test_require_unmixed_accepts_one_version(folder: Path) -> None:
    install(folder, "mujoco-core", "4.0.0", {"mujoco/__init__.py": "x = 1"})
    install(folder, "mujoco", "4.0.0", {"mujoco/__init__.py": "x = 1"})
    install(folder, "pybullet-arm64", "3.2.8", {"pybullet.so": "", "pybullet_data/a.urdf": "<a/>"})
    for module in ("mujoco", "pybullet", "numpy"):
        require_unmixed(module)


@pytest.mark.parametrize("after", ["another text", None])
def test_require_unmixed_reports_changed_and_missing_files(folder: Path, after: str | None) -> None:
    install(folder, "mujoco-core", "4.0.0", {"mujoco/engine.so": "code", "bin/tool": "x"})
    if after is None:
        (folder / "mujoco" / "engine.so").unlink()
    else:
        (folder / "mujoco" / "engine.so").write_text(after, encoding="utf-8")
    with pytest.raises(UsageError, match=r"mujoco-core 4\.0\.0 are missing or of another version"):
        require_unmixed("mujoco")


def test_require_unmixed_refuses_an_older_version(folder: Path) -> None:
    install(folder, "mujoco", "3.17.0", {"mujoco/__init__.py": ""})
    with pytest.raises(UsageError, match=r"mujoco 3\.17\.0 is installed; cbdsl needs version 4"):
        require_unmixed("mujoco")


def test_find_backend_reports_mixed_files_before_they_are_imported(folder: Path) -> None:
    install(folder, "mujoco-core", "4.0.1", {})
    install(folder, "mujoco", "3.17.0", {})
    with pytest.raises(BackendError, match="overwrite each other"):
        find_backend("mujoco")
