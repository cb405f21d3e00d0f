"""Documents of a git revision, for ``PROGRAM@REVISION``."""

from __future__ import annotations

import io
import subprocess
import tarfile
from pathlib import Path

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
    top = Path(_git(here, program, "rev-parse", "--show-toplevel").decode().strip()).resolve()
    commit = _git(
        here, program, "rev-parse", "--verify", "--end-of-options", f"{revision}^{{commit}}"
    )
    archive = _git(top, program, "archive", "--format=tar", commit.decode().strip())
    with tarfile.open(fileobj=io.BytesIO(archive)) as files:
        files.extractall(target, filter="data")
    folder = target / here.resolve().relative_to(top)
    return str(folder / file.name) if is_file else name, folder


def _git(folder: Path, program: str, *words: str) -> bytes:
    try:
        done = subprocess.run(["git", "-C", folder, *words], capture_output=True)
    except OSError as error:
        raise UsageError(f"{program}: git is not installed") from error
    if done.returncode:
        reason = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        raise UsageError(f"{program}: {' '.join(reason).removeprefix('fatal: ')}")
    return done.stdout
