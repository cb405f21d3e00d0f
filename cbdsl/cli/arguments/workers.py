"""Checks of workers: their number on this machine, and the security of a cluster."""

from __future__ import annotations

import os
from ipaddress import ip_address
from urllib.parse import urlsplit

from cbdsl.cli.output.terminal import print_problem
from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.errors import UsageError

# Each simulates without a pause, and takes a few hundred megabytes; beyond the processors they only
# wait for each other.
_PER_PROCESSOR = 4
_ALWAYS = 8
_HERE = ("localhost", "")


def require_workers(workers: int) -> None:
    """Reject more processes than this machine can keep busy.

    Raises:
        UsageError: The number of workers exceeds the limit.
    """
    # The affinity excludes processors that a batch system withholds; only Linux has it.
    affinity = getattr(os, "sched_getaffinity", None)
    processors = len(affinity(0)) if affinity else os.cpu_count() or 1
    most = max(_ALWAYS, _PER_PROCESSOR * processors)
    if workers > most:
        raise UsageError(
            f"--workers {workers}: at most {most} here, of a machine with "
            f"{count(processors, 'processor')}"
        )


def warn_of_open_scheduler(address: str) -> None:
    """Warn of a remote scheduler with connections that are neither encrypted nor authenticated.

    A host that can connect to it can run any code on its workers, and by replies on this machine.
    """
    scheme, _, rest = address.rpartition("://")
    try:
        host = urlsplit(f"//{rest}").hostname or ""
    except ValueError:
        return  # not an address; the failed connection is reported later
    # Without a scheme, Dask uses `tcp`. Others, such as `ucx`, are as open.
    if scheme not in ("tls", "wss", "inproc") and not _is_here(host):
        print_problem(
            f"warning: {address} is neither encrypted nor asks who connects: whoever reaches it "
            "runs code on it and here. Dask's TLS is a tls:// address and certificates"
        )


def _is_here(host: str) -> bool:
    """Return whether a host is this machine: localhost, or a loopback address."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host in _HERE
