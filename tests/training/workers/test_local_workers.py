"""Workers of this machine: the outcome of one process, out of reach of others, safe imports."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.training.workers.local_workers import run_on_workers
from tests.training.notes import Notes, episodes, until
from tests.training.tasks import made_tasks, outcome, run_here

psutil = pytest.importorskip("psutil")

TRIALS, EPISODES = 3, 12
ENDLESS = 1_000_000
LEARN = ["learn", "searchtrack", "--stage", "searchtrack_training", "--episodes", "100000"]
LEARN += ["--backend", "kinematic", "--out", "p.yaml", "--trials", "3", "--workers", "2"]


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return documents that the trials of this file write in one process."""
    folder = tmp_path_factory.mktemp("alone")
    run_here(made_tasks(folder, TRIALS, EPISODES))
    return outcome(folder)


def at_work() -> list[psutil.Process]:
    """Return child processes that write a journal."""
    found = []
    for child in psutil.Process().children(recursive=True):
        try:
            files = [Path(file.path).name for file in child.open_files()]
        except psutil.Error:  # it ended meanwhile
            continue
        if any(name.endswith(".episodes.jsonl") for name in files):
            found.append(child)
    return found


def test_run_on_workers_writes_the_documents_of_one_process(
    tmp_path: Path, expected: dict[str, bytes]
) -> None:
    notes, before = Notes(), set(psutil.Process().children())
    run_on_workers(made_tasks(tmp_path, TRIALS, EPISODES), 2, notes)
    assert outcome(tmp_path) == expected
    assert sorted(file.name for file in notes.files) == sorted(expected)
    assert notes.failures == [] and set(notes.workers) == {2}
    assert set(psutil.Process().children()) <= before


@pytest.mark.slow
def test_run_on_workers_reports_failed_trials_and_finishes_the_others(tmp_path: Path) -> None:
    tasks, notes = made_tasks(tmp_path, 3, 1), Notes()
    tasks[1].path.with_suffix(".episodes.jsonl").mkdir()
    run_on_workers(tasks, 2, notes)
    assert [told[:8] for told in notes.failures] == ["trial 1:"]
    assert {file.name for file in notes.files} >= {"policy_0.yaml", "policy_2.yaml"}


class Deadly:
    """Job that ends its process, and counts how often."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, ...]:
        return (_die, (str(self.path),))


def _die(path: str) -> None:
    with Path(path).open("a") as file:
        file.write("x")
    os._exit(1)


@pytest.mark.slow
def test_run_on_workers_gives_up_a_job_that_ends_its_workers(tmp_path: Path) -> None:
    notes, job = Notes(), Deadly(tmp_path / "deaths")
    job.number = 0
    run_on_workers([job], 1, notes)
    assert job.path.read_text() == "xxxx"
    assert notes.failures == ["trial 0: the workers that it was given to died, one after the other"]


@pytest.mark.slow
def test_run_on_workers_after_a_killed_worker_loses_no_trial(
    tmp_path: Path, expected: dict[str, bytes]
) -> None:
    folders = (tmp_path / str(attempt) for attempt in itertools.count())
    while not (killed := worker_killed(folder := next(folders))):
        pass  # all trials were over before
    assert killed.failures == []
    assert outcome(folder) == expected


def worker_killed(folder: Path) -> Notes | None:
    """Return the notes of trials of which one loses its worker; ``None`` if they ended early."""
    folder.mkdir()
    tasks, notes = made_tasks(folder, TRIALS, EPISODES), Notes()
    thread = threading.Thread(target=run_on_workers, args=(tasks, 2, notes), daemon=True)
    thread.start()
    while thread.is_alive() and not (any(map(episodes, tasks)) and at_work()):
        time.sleep(0.02)
    victims = at_work()
    if victims:
        victims[0].kill()
    thread.join()
    return notes if victims else None


class Interrupting(Notes):
    """Ends the command once a trial has an episode, after a look at its processes."""

    def __init__(self, tasks: list) -> None:
        super().__init__()
        self.tasks, self.processes = tasks, []
        # Other tests may have left processes, such as trackers of shared memory.
        self.before = set(psutil.Process().children())

    def look(self, workers: int) -> None:
        if any(map(episodes, self.tasks)):
            own = [each for each in psutil.Process().children() if each not in self.before]
            self.processes = [psutil.Process(), *own]
            self.sockets = [each for p in self.processes for each in p.net_connections("all")]
            self.denied = [denied(p.pid) for p in self.processes[1:]]
            raise UsageError("seen enough")


def denied(pid: int) -> bool:
    """Return whether another user of this machine is denied a process's pipes."""
    opens = f'for n in 3 4 5 6 7 8 9; do (: <>/proc/{pid}/fd/$n) && echo "open $n"; done'
    done = subprocess.run(
        ["/bin/sh", "-c", f"kill -0 {pid} && echo signalled; {opens}"],
        user=65534, group=65534, extra_groups=[], cwd="/", capture_output=True,
    )  # fmt: skip
    return not done.stdout and b"denied" in done.stderr


@pytest.mark.skipif(os.geteuid() != 0, reason="acts as another user, which needs root")
def test_run_on_workers_listens_nowhere_and_denies_other_users(tmp_path: Path) -> None:
    tasks = [replace(each, episodes=ENDLESS) for each in made_tasks(tmp_path, 2, 1)]
    notes = Interrupting(tasks)
    with pytest.raises(UsageError, match="seen enough"):
        run_on_workers(tasks, 2, notes)
    assert len(notes.processes) == 3 and notes.denied == [True, True]
    reachable = [
        each for each in notes.sockets if each.status == psutil.CONN_LISTEN or
        (not each.raddr and isinstance(each.laddr, str) and each.laddr)
    ]  # fmt: skip
    assert reachable == []
    assert set(psutil.Process().children()) <= notes.before


@contextmanager
def command(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Start ``cb learn`` with two workers in a folder."""
    process = subprocess.Popen(
        [str(Path(sys.executable).parent / "cb"), *LEARN],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def workers(process: subprocess.Popen[str]) -> int:
    children = psutil.Process(process.pid).children()
    return sum("worker_process" in " ".join(each.cmdline()) for each in children)


def test_learn_with_workers_imports_nothing_from_the_current_folder(tmp_path: Path) -> None:
    names = (*sys.stdlib_module_names, "numpy", "cbdsl", "networkx", "pydantic", "sitecustomize")
    for name in names:
        (tmp_path / f"{name}.py").write_text("open('RAN_' + __name__, 'w').close()\n")
    with command(tmp_path) as process:
        until(lambda: process.poll() is not None or any(tmp_path.glob("*.episodes.jsonl")))
        process.terminate()
        told = process.communicate(timeout=120)[0]
    assert not list(tmp_path.glob("RAN_*"))
    assert "interrupted" in told


@pytest.mark.slow
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_interrupt_while_workers_begin_is_one_line(sent: signal.Signals, tmp_path: Path) -> None:
    with command(tmp_path) as process:
        until(lambda: process.poll() is not None or workers(process) >= 2)
        if sent == signal.SIGINT:  # as a terminal does
            os.killpg(process.pid, sent)
        else:
            process.send_signal(sent)
        told = process.communicate(timeout=120)[0]
    assert process.returncode == 130
    assert told.splitlines()[-1].startswith("cb: interrupted")
    assert all(line.startswith("workers: ") for line in told.splitlines()[:-1])
