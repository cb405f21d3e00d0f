"""Clusters: trials on other machines, for the entry-point group ``cbdsl.clusters``.

An entry is a function of tasks, the address of a scheduler, and a ``Supervisor``; ``--scheduler``
calls the entry ``dask``. It runs each task by ``run_task`` in a process of one thread, with the
``versions`` of the caller, and reports its outcome. It raises ``UsageError`` if the cluster is not
there, goes away, or has no workers. The contract test is ``cbdsl.extend.contract.test_cluster``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.training.provenance import versions
    from cbdsl.training.task import AbandonedError, Task, run_task
    from cbdsl.training.task_observer import TaskObserver
    from cbdsl.training.workers.local_workers import Supervisor

__all__ = [
    "AbandonedError", "Supervisor", "Task", "TaskObserver", "UsageError", "run_task", "versions",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
