"""Folders of documents: hidden, vendored, ignored and foreign files are skipped."""

from __future__ import annotations

import os
import random
import shutil
import subprocess
from pathlib import Path

import pytest

from cbdsl.yaml_text.document_folder import documents_below

DOCUMENT = "cbdsl: 1\nkind: program\n"


def write(root: Path, *names: str, text: str = DOCUMENT) -> None:
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")


def found(folder: Path) -> list[str]:
    return [file.relative_to(folder).as_posix() for file in documents_below(folder).documents]


def test_documents_below_a_folder_are_sorted_and_others_are_counted(tmp_path: Path) -> None:
    write(tmp_path, "programs/b.yaml", "a.yml", "robots/deep/down/c.yaml")
    write(tmp_path, "docker-compose.yml", "charts/t.yaml", text="services: {}\n")
    write(tmp_path, "programs/unfinished.yaml", "empty.yaml", text="")
    result = documents_below(tmp_path)
    assert found(tmp_path) == [
        "a.yml", "programs/b.yaml", "programs/unfinished.yaml", "robots/deep/down/c.yaml",
    ]  # fmt: skip
    assert (result.others, result.unreadable) == (3, 0)


@pytest.mark.parametrize(
    "skipped",
    [".venv/lib", ".github/workflows", "node_modules/x", "vendor/cbdsl", "lib/site-packages/p"],
)
def test_documents_in_a_hidden_or_vendored_folder_are_skipped(tmp_path: Path, skipped: str) -> None:
    write(tmp_path, "a.yaml", f"{skipped}/b.yaml", f"sub/{skipped}/c.yaml")
    assert found(tmp_path) == ["a.yaml"]
    assert found(tmp_path / skipped) == ["b.yaml"], "a folder that is named is searched"


@pytest.mark.parametrize("mark", ["pyvenv.cfg", "CACHEDIR.TAG", "COLCON_IGNORE"])
def test_documents_in_a_marked_folder_are_skipped(tmp_path: Path, mark: str) -> None:
    write(tmp_path, "a.yaml", "env/b.yaml", "env/deep/c.yaml")
    write(tmp_path, f"env/{mark}", text="")
    assert found(tmp_path) == ["a.yaml"]


def test_documents_that_git_ignores_are_skipped_as_git_does(tmp_path: Path) -> None:
    write(tmp_path, "a.yaml", "build/b.yaml", "sub/build/c.yaml", "sub/drop.yaml", "sub/keep.yaml")
    write(tmp_path, "sub/deep/drop.yaml", "sub/deep/x.gen.yaml", "local.yaml", "top/only.yaml")
    write(tmp_path, ".gitignore", text="build/\n*.gen.yaml\n/only.yaml\n[\n!\n")
    write(tmp_path, "sub/.gitignore", text="drop.yaml\n!deep/drop.yaml\n!*.gen.yaml\n")
    write(tmp_path, ".git/info/exclude", text="local.yaml\n")
    expected = ["a.yaml", "sub/deep/drop.yaml", "sub/deep/x.gen.yaml", "sub/keep.yaml"]
    assert found(tmp_path) == [*expected, "top/only.yaml"]
    assert found(tmp_path / "sub") == ["deep/drop.yaml", "deep/x.gen.yaml", "keep.yaml"]
    assert found(tmp_path / "build") == ["b.yaml"], "a folder that is named is searched"


@pytest.mark.skipif(shutil.which("git") is None, reason="needs git")
@pytest.mark.parametrize("seed", range(12))
def test_documents_found_are_those_that_git_lists(tmp_path: Path, seed: int) -> None:
    rng = random.Random(seed)
    folders = ["", "a/", "a/b/", "a/b/c/", "d/"]
    write(tmp_path, *(f"{folder}{name}.yaml" for folder in folders for name in "xyz"))
    patterns = [
        "x.yaml",
        "/y.yaml",
        "a/",
        "b/*",
        "!x.yaml",
        "**/c",
        "d/z.yaml",
        "*.yaml",
        "!b/",
        "#",
    ]
    for folder in rng.sample(folders, 3):
        lines = "\n".join(rng.sample(patterns, 3))
        write(tmp_path, f"{folder}.gitignore", text=lines + "\n")
    git = ["git", "-C", str(tmp_path)]
    environment = {**os.environ, "GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_SYSTEM": os.devnull}
    subprocess.run([*git, "init", "-q"], check=True, env=environment)
    listed = subprocess.run(
        [*git, "ls-files", "--others", "--exclude-standard", "*.yaml"],
        check=True, capture_output=True, text=True, env=environment,
    ).stdout.splitlines()  # fmt: skip
    assert found(tmp_path) == sorted(listed, key=Path)


def test_folders_that_cannot_be_read_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, "a.yaml", "shut/b.yaml")
    scan = os.scandir

    def refuse(path: str) -> object:
        if Path(path).name == "shut":
            raise PermissionError(13, "Permission denied", str(path))
        return scan(path)

    monkeypatch.setattr(os, "scandir", refuse)
    result = documents_below(tmp_path)
    assert ([file.name for file in result.documents], result.unreadable) == (["a.yaml"], 1)


def test_links_and_pipes_stop_nothing(tmp_path: Path) -> None:
    write(tmp_path, "a.yaml")
    (tmp_path / "loop").symlink_to(tmp_path)
    (tmp_path / "itself.yaml").symlink_to(tmp_path / "itself.yaml")
    (tmp_path / "nowhere.yaml").symlink_to(tmp_path / "missing")
    os.mkfifo(tmp_path / "pipe.yaml")
    files = ["a.yaml", "itself.yaml", "nowhere.yaml", "pipe.yaml"]
    assert found(tmp_path) == files, "a reader reports those that cannot be read"


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs /proc")
def test_kernels_files_are_no_documents() -> None:
    assert documents_below(Path("/proc/self")).documents == ()
