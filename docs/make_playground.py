"""Make the playground that needs no installation: the checker in Python that the browser runs.

Run ``python docs/make_playground.py`` before the site is built for readers. It writes
docs/playground/, which is not under version control, from the installed packages, Pyodide (npm),
and the compiled part of pydantic for it (pip).
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib.metadata import distribution
from importlib.resources import files
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

from cbdsl_report.playground import playground_page

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "docs" / "in_browser"
FOLDER = ROOT / "docs" / "playground"
#: Modules of the distribution with the playground, which this project's licence covers.
_MODULES = ROOT / "distributions" / "cbdsl-report" / "cbdsl_report"
#: Files of Pyodide that a browser loads.
RUNTIME = (
    "pyodide.mjs",
    "pyodide.asm.mjs",
    "pyodide.asm.wasm",
    "python_stdlib.zip",
    "pyodide-lock.json",
)
#: The only package that cannot do without its compiled part.
COMPILED = "pydantic_core"
_PLATFORM = ("--platform", "pyemscripten_2026_0_wasm32", "--python-version", "3.14")
#: Parts of names of files that are left out.
_LEFT_OUT = {"..", "__pycache__", "tests"}
_NAME = re.compile(r"[\w.-]+")


def main(folder: Path = FOLDER) -> None:
    """Write the playground into a folder.

    Args:
        folder: It is created, and its files are replaced.

    Raises:
        SystemExit: npm or pip is not installed or reaches no registry.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        _copy_runtime(folder, Path(scratch))
        _pack(folder / "packages.zip", Path(scratch))
    shutil.copyfile(SOURCES / "worker.mjs", folder / "worker.mjs")
    (folder / "index.html").write_text(page(), "utf-8")


def page() -> str:
    """Return the page of the playground, which asks a worker in the place of a server."""
    text = (ROOT / "programs" / "let_go.yaml").read_text("utf-8")
    html = playground_page(text, token="")
    served = files("cbdsl.reporting").joinpath("assets", "asking.js").read_text("utf-8")
    html = html.replace(served, (SOURCES / "asking.js").read_text("utf-8"), 1)
    return html.replace("connect-src 'self'", "connect-src 'self'; worker-src 'self'", 1)


def _copy_runtime(folder: Path, scratch: Path) -> None:
    for name in ("package.json", "package-lock.json"):
        shutil.copyfile(SOURCES / name, scratch / name)
    _do("npm", "ci", "--prefix", str(scratch))
    for name in RUNTIME:
        shutil.copyfile(scratch / "node_modules" / "pyodide" / name, folder / name)


def _pack(archive: Path, scratch: Path) -> None:
    """Write Python's files of the package and of its requirements, without compiled ones."""
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet")
    core = f"{COMPILED}=={distribution(COMPILED).version}"
    _do(*pip, "wheel", "--no-deps", "--wheel-dir", str(scratch), str(ROOT))
    _do(*pip, "download", "--no-deps", "--only-binary=:all:", *_PLATFORM, "-d", str(scratch), core)
    with ZipFile(archive, "w", ZIP_DEFLATED) as packed:
        packed.write(SOURCES / "answers.py", "answers.py")
        for file in _MODULES.glob("*.py"):
            packed.write(file, f"{_MODULES.name}/{file.name}")
        for wheel in scratch.glob("*.whl"):
            with ZipFile(wheel) as opened:
                for name in opened.namelist():
                    packed.writestr(name, opened.read(name))
        for file, name in _required_files():
            packed.write(file, name)


def _required_files() -> Iterator[tuple[Path, str]]:
    """Yield each file of Python of the packages that the package requires, and its place."""
    names, found = ["cbdsl"], {"cbdsl", COMPILED}
    for name in names:
        for requirement in distribution(name).requires or ():
            required = _NAME.match(requirement)
            if required and ";" not in requirement and required[0].replace("-", "_") not in found:
                found.add(required[0].replace("-", "_"))
                names.append(required[0])
    for name in names[1:]:
        for file in distribution(name).files or ():
            if file.suffix != ".so" and _LEFT_OUT.isdisjoint(file.parts):
                yield Path(str(file.locate())), str(file)


def _do(*command: str) -> None:
    try:
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    except (OSError, subprocess.CalledProcessError) as error:
        raise SystemExit(f"the playground of the site is not made: {error}") from None


if __name__ == "__main__":
    main()
