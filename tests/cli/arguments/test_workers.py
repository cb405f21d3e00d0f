"""Workers: their number is bounded, and open schedulers of clusters cause a warning."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from cbdsl.cli.arguments.workers import require_workers, warn_of_open_scheduler
from cbdsl.diagnostics.errors import UsageError
from tests.cli.test_main import cb


def test_at_most_four_workers_per_processor_are_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(10)))
    require_workers(40)
    with pytest.raises(UsageError, match="--workers 41: at most 40 here"):
        require_workers(41)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
    require_workers(8)


@pytest.mark.parametrize(
    "command",
    [
        ["learn", "searchtrack", "--out", "policy.yaml", "--trials", "500"],
        ["reproduce", "fig_4_5"],
    ],
)
def test_too_many_workers_are_refused_before_the_first_episode(
    command: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, *command, "--workers", "5000") == 2
    assert capsys.readouterr().err.startswith("cb: --workers 5000: at most ")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("address", "is_open"),
    [
        ("tcp://login:8786", True),
        ("login:8786", True),
        ("tcp://10.0.0.7:8786", True),
        ("tcp://[2001:db8::1]:8786", True),
        ("ws://login:80", True),
        ("ucx://login:8786", True),
        ("asyncio-tcp://login:8786", True),
        ("tls://login:8786", False),
        ("wss://login:443", False),
        ("tcp://127.evil.example:8786", True),
        ("tcp://127.0.0.1.evil.example:8786", True),
        ("tcp://localhost.evil.example:8786", True),
        ("tcp://127.0.0.1:8786", False),
        ("tcp://127.8.8.8:8786", False),
        ("tcp://[::1]:8786", False),
        ("localhost:8786", False),
        ("tcp://[nonsense", False),
    ],
)
def test_plain_scheduler_on_another_machine_gives_a_warning(
    address: str, is_open: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    warn_of_open_scheduler(address)
    told = capsys.readouterr().err
    assert told.startswith(f"cb: warning: {address} is neither encrypted") == is_open
    assert bool(told) == is_open
