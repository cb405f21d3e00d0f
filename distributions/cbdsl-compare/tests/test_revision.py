"""``PROGRAM@REVISION``: documents of a git revision, with reasons where there are none."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from cbdsl import UsageError
from cbdsl_compare.revision import written_revision
from tests.cli.arm_program import TEXT
from tests.cli.test_main import cb

_PERSON = ("-c", "user.name=a", "-c", "user.email=a@b")


def git(folder: Path, *words: str) -> None:
    subprocess.run(["git", "-C", folder, *_PERSON, *words], check=True, capture_output=True)


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """Repository of two revisions of a program in a folder, and a temporary state."""
    folder = tmp_path / "repository" / "lab"
    (folder / "programs").mkdir(parents=True)
    git(folder.parent, "init", "-q")
    for text in ("first", "second"):
        (folder / "programs" / "own.yaml").write_text(text, "utf-8")
        git(folder, "add", ".")
        git(folder, "commit", "-q", "-m", text)
    (folder / "programs" / "own.yaml").write_text("third", "utf-8")
    return folder


def test_name_at_a_revision_is_found_in_its_folder(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(repository)
    name, folder = written_revision("own@HEAD~1", tmp_path / "target")
    assert name == "own"
    assert folder is not None
    assert (folder / "programs" / "own.yaml").read_text("utf-8") == "first"
    assert (repository / "programs" / "own.yaml").read_text("utf-8") == "third"


def test_file_at_a_revision_is_the_file_of_that_revision(repository: Path, tmp_path: Path) -> None:
    file, _ = written_revision(f"{repository}/programs/own.yaml@HEAD", tmp_path / "target")
    assert Path(file).read_text("utf-8") == "second"


def test_program_without_a_revision_stays(tmp_path: Path) -> None:
    assert written_revision("reach", tmp_path) == ("reach", None)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("revision", ["nonsense", "", "--help", "HEAD:lab"])
def test_unknown_revision_is_refused_with_its_name(
    revision: str, repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(repository)
    with pytest.raises(UsageError, match=f"own@{revision}: "):
        written_revision(f"own@{revision}", tmp_path / "target")


def test_folder_outside_of_a_repository_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    with pytest.raises(UsageError, match="own@HEAD: not a git repository"):
        written_revision("own@HEAD", tmp_path / "target")


def test_revision_runs_no_filter_of_its_repository(repository: Path, tmp_path: Path) -> None:
    file = repository / "programs" / "own.yaml"
    (repository / ".gitattributes").write_text("*.yaml filter=theirs\n", "utf-8")
    git(repository, "add", ".")
    git(repository, "commit", "-q", "-m", "filtered")
    git(repository, "config", "filter.theirs.smudge", f"touch {tmp_path}/ran; cat")
    program, _ = written_revision(f"{file}@HEAD", tmp_path / "target")
    assert Path(program).read_text("utf-8") == "third"
    assert not (tmp_path / "ran").exists()


def test_revision_whose_files_are_elsewhere_connects_nowhere(
    repository: Path, tmp_path: Path
) -> None:
    partial = tmp_path / "partial"
    git(repository.parent, "config", "uploadpack.allowFilter", "true")
    git(tmp_path, "clone", "-q", "--filter=blob:none", f"file://{repository.parent}", "partial")
    git(partial, "config", "remote.origin.uploadpack", f"touch {tmp_path}/ran; git-upload-pack")
    with pytest.raises(UsageError, match=r"own\.yaml@HEAD~1: "):
        written_revision(f"{partial}/lab/programs/own.yaml@HEAD~1", tmp_path / "target")
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("leads_to", ["/etc/passwd", "../../../../../../etc/passwd"])
def test_revision_with_a_link_out_of_its_folder_is_read_without_it(
    leads_to: str, repository: Path, tmp_path: Path
) -> None:
    for name, place in {"inside.yaml": "own.yaml", "outside.yaml": leads_to}.items():
        (repository / "programs" / name).symlink_to(place)
    git(repository, "add", ".")
    git(repository, "commit", "-q", "-m", "links")
    _, folder = written_revision(f"{repository}/programs/own.yaml@HEAD", tmp_path / "target")
    assert folder is not None
    assert sorted(each.name for each in folder.iterdir()) == ["inside.yaml", "own.yaml"]
    assert (folder / "inside.yaml").read_text("utf-8") == "third"


def test_compare_runs_a_program_of_a_revision(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "raise_arm.yaml"
    file.write_text(TEXT, "utf-8")
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-q", "-m", "raise the arm")
    file.write_text(f"{TEXT}limits: {{episode_time: 0.1 s}}\n", "utf-8")
    sides = [f"{file}{revision},backend=kinematic" for revision in ("@HEAD", "")]
    assert cb(monkeypatch, "compare", *sides, "--seeds", "0-1", "--all", "--json") == 0
    row = json.loads(capsys.readouterr().out)
    assert (row["successes"], row["first_difference"]["failed"]) == ([2, 0], "B")
