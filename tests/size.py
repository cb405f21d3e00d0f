"""Lines of each package of cbdsl, and their ceilings; ``python -m tests.size`` lowers these."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from tests.conftest import ROOT

LIMITS = ROOT / "tests" / "size_limits.toml"
_HEAD = """\
# Largest number of lines of each package of cbdsl. `python -m tests.size` lowers them to
# the present sizes. A package that needs more takes the lines from another ceiling, or moves a part
# to a distribution: all together have at most 85,000 lines.
"""


def sizes(package: Path) -> dict[str, int]:
    """Return the lines of Python by subpackage; ``.`` has those of the package's own modules."""
    counts: Counter[str] = Counter()
    for file in package.rglob("*.py"):
        folders = file.relative_to(package).parts[:-1]
        counts[folders[0] if folders else "."] += file.read_text("utf-8").count("\n")
    return dict(sorted(counts.items()))


def read_limits() -> dict[str, int]:
    """Return the ceiling of each package."""
    return tomllib.loads(LIMITS.read_text("utf-8"))


def excess(found: Mapping[str, int], limits: Mapping[str, int]) -> dict[str, str]:
    """Return the packages beyond their ceilings, with both numbers."""
    return {
        name: f"{lines} lines, at most {limits.get(name, 0)}"
        for name, lines in found.items()
        if lines > limits.get(name, 0)
    }


def lowered(found: Mapping[str, int], limits: Mapping[str, int]) -> dict[str, int]:
    """Return ceilings at the present sizes, none higher than before."""
    return {name: min(limit, found[name]) for name, limit in limits.items() if name in found}


def text(limits: Mapping[str, int]) -> str:
    """Return the file of the ceilings."""
    return _HEAD + "".join(
        f"{name if name.isidentifier() else f'{name!r}'} = {limit}\n"
        for name, limit in limits.items()
    )


if __name__ == "__main__":
    LIMITS.write_text(text(lowered(sizes(ROOT / "cbdsl"), read_limits())), "utf-8")
