"""Trials on a Dask cluster: its outcome, its ends, and who is let in."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.training.provenance import versions
from tests.conftest import ROOT
from tests.test_docs import blocks
from tests.training.notes import Notes, episodes, until
from tests.training.tasks import made_tasks, outcome, run_here

distributed = pytest.importorskip("distributed", reason="trials side by side: extra 'learn'")

from cbdsl_learn.cluster import run_on_cluster, work  # noqa: E402

TRIALS, EPISODES = 3, 12
ENDLESS = 1_000_000


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return documents that the trials of this file write in one process."""
    folder = tmp_path_factory.mktemp("alone")
    run_here(made_tasks(folder, TRIALS, EPISODES))
    return outcome(folder)


@pytest.mark.slow
def test_lost_scheduler_is_reported_and_finished_episodes_are_kept(
    tmp_path: Path, expected: dict[str, bytes]
) -> None:
    tasks = made_tasks(tmp_path, TRIALS, EPISODES)
    longer = [replace(each, episodes=ENDLESS) for each in tasks]
    file = tmp_path / "scheduler.json"
    with dask("scheduler", file, "--port", "0") as scheduler, dask("worker", file, "--no-nanny"):
        until(file.exists)
        address = json.loads(file.read_text("utf-8"))["address"]

        def kill() -> None:
            until(lambda: any(map(episodes, longer)))
            scheduler.kill()

        threading.Thread(target=kill, daemon=True).start()
        with pytest.raises(UsageError, match="scheduler is gone"):
            run_on_cluster(longer, address, Notes())
        assert any(map(episodes, longer))
        # The worker gives the trial up by itself.
        run_here(tasks)
    assert outcome(tmp_path) == expected


class dask:  # noqa: N801
    """A process of Dask's, as ``dask scheduler`` and ``dask worker`` start it."""

    def __init__(self, what: str, file: Path, *words: str) -> None:
        module = [sys.executable, "-m", f"distributed.cli.dask_{what}"]
        if what == "worker":
            words = (*words, "--nthreads", "1")
        options = [*words, "--scheduler-file", str(file), "--no-dashboard"]
        self._process = subprocess.Popen([*module, *options], stderr=subprocess.DEVNULL)

    def __enter__(self) -> subprocess.Popen[bytes]:
        return self._process

    def __exit__(self, *error: object) -> None:
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()


@pytest.fixture
def threads() -> int:
    return 1


@pytest.fixture
def cluster(threads: int) -> Iterator[Any]:
    """Yield a cluster within this process, with one worker of so many threads or none."""
    workers = 1 if threads else 0
    with distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=threads,
        processes=False,
        dashboard_address=None,
        # Any free port: another test's cluster may have the usual one, which Dask would warn of.
        scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
    ) as found:
        yield found


@pytest.mark.parametrize("threads", [0])
def test_cluster_without_workers_is_waited_for_and_then_reported(
    tmp_path: Path, cluster: Any
) -> None:
    notes = Notes()
    with pytest.raises(UsageError, match="without workers for 1 s"):
        address = cluster.scheduler_address
        run_on_cluster(made_tasks(tmp_path, 1, 1), address, notes, patience=1.0)
    assert set(notes.workers) == {0}
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("threads", [0])
def test_run_on_cluster_removes_markers_of_killed_commands(tmp_path: Path, cluster: Any) -> None:
    host, dead = socket.gethostname(), subprocess.Popen(["true"])
    dead.wait()
    left = tmp_path / f".cb_learn_{host}_{dead.pid}_00"
    kept = [tmp_path / f".cb_learn_{host}_{os.getpid()}_00", tmp_path / ".cb_learn_other_1_00"]
    for marker in (left, *kept):
        marker.touch()
    with pytest.raises(UsageError, match="without workers"):
        address = cluster.scheduler_address
        run_on_cluster(made_tasks(tmp_path, 1, 1), address, Notes(), patience=0.5)
    assert set(tmp_path.iterdir()) == set(kept)


@pytest.mark.parametrize("threads", [2])
def test_worker_of_several_threads_is_refused_trial_by_trial(tmp_path: Path, cluster: Any) -> None:
    notes = Notes()
    run_on_cluster(made_tasks(tmp_path, 2, 1), cluster.scheduler_address, notes)
    assert sorted(told.partition(" inproc")[0] for told in notes.failures) == [
        "trial 0: worker",
        "trial 1: worker",
    ]
    assert all("has 2 threads" in told and "--nthreads 1" in told for told in notes.failures)
    assert list(tmp_path.iterdir()) == []


def test_worker_that_would_learn_something_else_is_refused(tmp_path: Path, cluster: Any) -> None:
    task, elsewhere = made_tasks(tmp_path, 1, 1)[0], tmp_path / "none" / "file"
    with distributed.Client(cluster) as client:
        for there, expected, told in (
            (elsewhere, versions(), f"does not see the files in {elsewhere.parent}"),
            (tmp_path, {**versions(), "numpy": "0.1"}, "not 0.1"),
            (tmp_path, {**versions(), "pip": "1.0"}, "has pip none, not 1.0"),
        ):
            with pytest.raises(UsageError, match=told):
                client.submit(work, task, there, expected, pure=False).result()
    assert list(tmp_path.iterdir()) == []


def test_abandoned_trial_ends_after_its_episode(tmp_path: Path, cluster: Any) -> None:
    task = replace(made_tasks(tmp_path, 1, 1)[0], episodes=ENDLESS)
    with distributed.Client(cluster) as client:
        future = client.submit(work, task, tmp_path, versions(), pure=False)
        until(lambda: episodes(task) or future.done())
    # Otherwise its journal would stay locked.
    run_here([replace(task, episodes=1)])
    assert outcome(tmp_path)


@pytest.mark.parametrize("address", ["nonsense", "tcp://127.0.0.1:nine"])
def test_no_address_of_a_scheduler_is_reported(tmp_path: Path, address: str) -> None:
    with pytest.raises(UsageError, match=rf"--scheduler {address}: nothing answers"):
        run_on_cluster(made_tasks(tmp_path, 1, 1), address, Notes())
    assert list(tmp_path.iterdir()) == []


def _answer(listening: socket.socket) -> None:
    """Answer every client like a server of pages."""
    while True:
        try:
            there, _ = listening.accept()
        except OSError:
            return
        with there, suppress(OSError):
            there.sendall(b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n")


def test_server_that_is_no_scheduler_is_reported(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        threading.Thread(target=_answer, args=(listening,), daemon=True).start()
        address = f"tcp://127.0.0.1:{listening.getsockname()[1]}"
        with pytest.raises(
            UsageError, match=f"--scheduler {address}: the server at this address is not"
        ):
            run_on_cluster(made_tasks(tmp_path, 1, 1), address, Notes())


def certificates(folder: Path) -> dict[str, str]:
    """Return settings of Dask for TLS with a certificate that signs itself."""
    pem, key = folder / "mine.pem", folder / "mine.key"
    make = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2"]
    make += ["-subj", "/CN=localhost", "-keyout", str(key), "-out", str(pem)]
    subprocess.run(make, check=True, capture_output=True)
    tls = "DASK_DISTRIBUTED__COMM__TLS__"
    settings = {f"{tls}CA_FILE": str(pem), "DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION": "True"}
    for role in ("SCHEDULER", "WORKER", "CLIENT"):
        settings |= {f"{tls}{role}__CERT": str(pem), f"{tls}{role}__KEY": str(key)}
    return settings


LEARN = """
import sys
from pathlib import Path
from cbdsl.diagnostics.errors import UsageError
from cbdsl_learn.cluster import run_on_cluster
from tests.training.tasks import made_tasks
from tests.training.notes import Notes
if __name__ == "__main__":
    notes = Notes()
    try:
        run_on_cluster(made_tasks(Path(sys.argv[1]), 1, 1), sys.argv[2], notes)
    except UsageError as error:
        print(error)
    print(notes.failures, len(notes.files))
"""


PAGE = ROOT / "docs" / "how_to" / "learn_on_a_cluster.md"


def of_page(word: str) -> list[str]:
    """Return lines of the page's block that has a word."""
    (found,) = [each for each in blocks(PAGE) if each.language == "sh" and word in each.text]
    return found.text.splitlines()


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("openssl"), reason="makes the certificates")
def test_page_leads_to_trials_over_tls_and_each_mistake_is_reported(tmp_path: Path) -> None:
    """Run its lines unchanged, except for the port and fewer episodes without physics."""
    for line in of_page("openssl x509"):
        subprocess.run(["bash", "-ec", line], cwd=tmp_path, check=True, capture_output=True)
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])
    settings, begin, join, learn = (
        "; ".join(of_page("--protocol tls")[k] for k in part) for part in ([0, 1], [2], [3], [4])
    )
    place = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": place}
    learn = learn.replace(
        "--episodes 100 --trials 40", "--backend kinematic --episodes 2 --trials 2"
    )

    def started(command: str, before: str = settings) -> subprocess.Popen[str]:
        script = f"{before}\nexec {command}".replace("8786", port).replace("//login", "//localhost")
        return subprocess.Popen(
            ["bash", "-ec", script],
            cwd=tmp_path,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def told(command: str, before: str = settings) -> str:
        return started(command, before).communicate(timeout=120)[0]

    cluster = [started(begin), started(join.replace("--nworkers 4", "--nworkers 1"))]
    try:
        assert "wrote" in told(learn)
        assert len(list(tmp_path.glob("many_*.yaml"))) == 4
        other = learn.replace("many.yaml", "other.yaml")
        gone = f"{settings}; export DASK_DISTRIBUTED__COMM__TLS__CLIENT__CERT=gone.pem"
        assert "there is no file gone.pem" in told(other, gone)
        assert "write tls://" in told(other.replace("tls:", "tcp:"))
        assert "TLS needs certificates" in told(other, "true")
        alone = "openssl req -x509 -newkey rsa:2048 -nodes -subj /CN=x -keyout x.key -out x.pem"
        tls = "export DASK_DISTRIBUTED__COMM__TLS__"
        foreign = f"{alone} 2>/dev/null; {settings}; {tls}CA_FILE=x.pem"
        foreign += f"; {tls}CLIENT__CERT=x.pem; {tls}CLIENT__KEY=x.key"
        assert "not signed by the same authority" in told(other, foreign)
        assert not list(tmp_path.glob("other*.yaml"))
    finally:
        for process in cluster:
            process.terminate()
            process.wait()


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("openssl"), reason="makes the certificates")
def test_dask_settings_admit_clients_with_a_certificate_only(tmp_path: Path) -> None:
    settings = certificates(tmp_path)
    inside = {**os.environ, **settings, "PYTHONPATH": str(ROOT)}
    outside = {**os.environ, "PYTHONPATH": str(ROOT)}
    address = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    quiet = {"env": inside, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    options = ["--protocol", "tls", "--port", "0", "--no-dashboard", "--interface", "lo"]
    scheduler = subprocess.Popen(
        [*dask, "scheduler", *options, "--scheduler-file", str(address)], **quiet
    )
    script = [sys.executable, "-c", LEARN]
    try:
        until(address.exists)
        at = json.loads(address.read_text())["address"]
        assert at.startswith("tls://")
        worker = subprocess.Popen(
            [*dask, "worker", at, "--nthreads", "1", "--no-dashboard", "--no-nanny"], **quiet
        )
        try:
            for environment, told in ((outside, "needs certificates"), (inside, "[] 2")):
                folder = tmp_path / told[:2]
                folder.mkdir()
                done = subprocess.run(
                    [*script, str(folder), at], env=environment, capture_output=True, text=True
                )
                assert told in done.stdout and "Traceback" not in done.stderr
        finally:
            worker.kill()
    finally:
        scheduler.kill()
