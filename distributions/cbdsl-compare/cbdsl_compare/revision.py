"""Documents of a git revision, for ``PROGRAM@REVISION``."""

from __future__ import annotations

import io
import os
import subprocess
import tarfile
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from cbdsl import UsageError


def written_revision(program: str, target: Path) -> tuple[str, Path | None]:
    """Write the documents of a revision to a folder; the code stays the present one.

    Args:
        program: File or name of a program, or ``PROGRAM@REVISION`` of its git repository: that of
            the file or, for a name, of the working folder.
        target: Empty folder.

    Returns:
        Program, and the folder to search for its documents; ``None`` for the working folder.

    Raises:
        UsageError: There is no such repository or revision, or git is not installed.
    """
    name, parted, revision = program.partition("@")
    if not parted:
        return program, None
    file = Path(name).absolute()
    is_file = file.suffix in (".yaml", ".yml")
    here = file.parent if is_file else Path.cwd()
    prefix = _git(here, program, "rev-parse", "--show-prefix")
    words = ("rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}")
    try:
        commit = _git(here, program, *words)
    except UsageError as error:
        raise UsageError(
            f"{program}: unknown revision '{revision}' (git log names revisions, such as HEAD~1)"
        ) from error
    objects = here / os.fsdecode(_git(here, program, "rev-parse", "--git-path", "objects"))
    archive = _archive(program, commit.decode(), objects)
    with tarfile.open(fileobj=io.BytesIO(archive)) as files:
        files.extractall(target, filter=_inside)
    folder = target / os.fsdecode(prefix)
    return str(folder / file.name) if is_file else name, folder


# The settings of a repository can name filters, and servers of missing files. Git would run both,
# so that an empty repository borrows the files here.
def _archive(program: str, commit: str, objects: Path) -> bytes:
    """Return the files of a commit as tar, without any program of the repository or the network."""
    settings = {
        "GIT_OBJECT_DIRECTORY": str(objects),
        "GIT_CONFIG_GLOBAL": os.devnull,
        "GIT_CONFIG_NOSYSTEM": "1",
        "GIT_ATTR_NOSYSTEM": "1",
    }
    kind = "sha256" if len(commit) == 64 else "sha1"
    with TemporaryDirectory() as empty:
        here = Path(empty)
        _git(here, program, "init", "--quiet", "--bare", "--template=", f"--object-format={kind}")
        return _git(here, program, "archive", "--format=tar", commit, settings=settings)


def _inside(member: tarfile.TarInfo, target: str) -> tarfile.TarInfo | None:
    """Return a part of an archive, or ``None`` if it leads out of the folder, as links can."""
    try:
        return tarfile.data_filter(member, target)
    except tarfile.FilterError:
        return None


def _git(
    folder: Path, program: str, *words: str, settings: Mapping[str, str] | None = None
) -> bytes:
    """Return the output of a command of git, without the last line break."""
    try:
        done = subprocess.run(
            ["git", "-C", folder, *words],
            capture_output=True,
            env={**os.environ, **(settings or {})},
        )
    except OSError as error:
        raise UsageError(f"{program}: git is not installed") from error
    if done.returncode:
        reason = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        raise UsageError(f"{program}: {' '.join(reason).removeprefix('fatal: ')}")
    return done.stdout.removesuffix(b"\n")
