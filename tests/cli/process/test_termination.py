"""SIGTERM and SIGHUP: they end a command like an interrupt from the keyboard."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cbdsl.cli.process.termination import stop_requests, termination_interrupts
from tests.conftest import ROOT

# Processes started in the background ignore SIGINT, and their children inherit that.
AT_A_KEYBOARD = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
COMMAND = AT_A_KEYBOARD + "from cbdsl.cli.main import main; main()"
LEARN = (
    *("learn", "searchtrack", "--stage", "searchtrack_training", "--backend", "kinematic"),
    *("--episodes", "1000000", "--out", "policy.yaml"),
)


@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGHUP])
def test_signal_raises_an_interrupt_and_the_handler_is_restored(sent: signal.Signals) -> None:
    before = signal.getsignal(sent)
    with pytest.raises(KeyboardInterrupt), termination_interrupts():
        os.kill(os.getpid(), sent)
        time.sleep(5)
    assert signal.getsignal(sent) is before


def test_signals_are_noted_until_a_loop_ends() -> None:
    with stop_requests() as stopped:
        assert not stopped()
        os.kill(os.getpid(), signal.SIGHUP)
        time.sleep(0.01)
        assert stopped()


def test_hangup_that_nohup_ignores_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with termination_interrupts(), stop_requests() as stopped:
            os.kill(os.getpid(), signal.SIGHUP)
            time.sleep(0.01)
            assert not stopped()
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.slow
@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_interrupted_trial_reports_how_to_continue(sent: signal.Signals, tmp_path: Path) -> None:
    lesson = subprocess.Popen(
        [sys.executable, "-c", COMMAND, *LEARN],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    journal = tmp_path / "policy.episodes.jsonl"
    while lesson.poll() is None and not (
        journal.exists() and journal.read_bytes().count(b"\n") > 2
    ):
        time.sleep(0.05)
    lesson.send_signal(sent)
    try:
        told = lesson.communicate(timeout=120)[1]
    finally:
        lesson.kill()
    assert (lesson.returncode, told.count("\n")) == (130, 1)
    assert told.startswith("cb: interrupted") and str(journal) in told and "--resume" in told
