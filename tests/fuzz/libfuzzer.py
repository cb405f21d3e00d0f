"""One entry point under libFuzzer, in a process of its own, which libFuzzer ends.

``python -m tests.fuzz`` runs ``python -m tests.fuzz.libfuzzer NAME FOLDER... -OPTION=...``.
"""

from __future__ import annotations

import sys

import atheris

# Compiled code has no branches that Python could report, and modules whose functions are compiled
# must stay as they are written.
_LEFT_OUT = ["cbdsl.control", "cbdsl.numeric", "cbdsl.sensing", "cbdsl.backends"]


def main() -> None:
    """Fuzz until time is over, or until something is found."""
    name = sys.argv.pop(1)
    # Much is imported when it is first needed: the importer reports branches until the end.
    with atheris.instrument_imports(include=["cbdsl"], exclude=_LEFT_OUT):
        from tests.fuzz.entry_point import entry_point

        read = entry_point(name).read
        atheris.Setup(sys.argv, lambda data: read(bytes(data)))
        atheris.Fuzz()


if __name__ == "__main__":
    main()
