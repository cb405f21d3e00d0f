"""Results of judges in files, in which a run replaces only the rows that it measured."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

#: Keys of a result that describe its run; a kept row holds those of its own run.
RUN = ("command", "commit", "versions", "backend", "cameras", "seed", "episodes")


def read_result(file: Path) -> dict[str, Any] | None:
    """Return the result in a file, or ``None`` if there is no file.

    Raises:
        OSError: The file cannot be read.
        UsageError: It is no result of the judge that it is named after.
    """
    from cbdsl import UsageError

    if not file.exists():
        return None
    try:
        result = json.loads(file.read_text(encoding="utf-8"))
    except ValueError:
        result = None
    if not isinstance(result, dict) or result.get("judge") != file.stem:
        raise UsageError(f"{file}: holds no result of cb judge {file.stem}; move it away")
    return result


def merged(result: Mapping[str, Any], known: Mapping[str, Any]) -> dict[str, Any]:
    """Return a result with the rows of a kept one for conditions that it has not measured.

    Args:
        result: Result of the new run.
        known: Kept result of the same judge.
    """
    measured = result["measures"].keys()
    run = {key: known.get(key) for key in RUN}
    kept = [{"run": run, **row} for row in known["rows"] if row["condition"] not in measured]
    rows = [*result["rows"], *kept]
    # Conditions keep their order in the file, and new ones follow.
    order = list(dict.fromkeys(row["condition"] for row in (*known["rows"], *rows)))
    rows.sort(key=lambda row: order.index(row["condition"]))
    return {
        **result,
        "met": all(row["met"] for row in rows),
        "rows": rows,
        "measures": {**known["measures"], **result["measures"]},
    }


def measured_alike(
    known: Mapping[str, Any], run: Mapping[str, Any], digests: Mapping[str, Mapping[str, str]]
) -> Collection[str]:
    """Return the conditions of a kept result that were measured in the setting of a run.

    Args:
        known: Kept result of the same judge.
        run: Values of the keys ``RUN`` of the new run; its command and its commit do not count.
        digests: Digests of all that a row depends on, by condition of the new run.
    """
    setting = {key: run[key] for key in RUN if key not in ("command", "commit")}
    return {
        row["condition"]
        for row in known["rows"]
        if setting.items() <= dict(row.get("run", known)).items()
        and row.get("digests") == digests.get(row["condition"])
    }
