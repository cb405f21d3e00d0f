"""``cbdsl.load``: a program on a stage, checked."""

from __future__ import annotations

from cbdsl.api.requests.declaration import verb
from cbdsl.api.requests.load_request import LoadRequest
from cbdsl.api.requests.run_request import RunRequest


@verb(LoadRequest)
def load(request: LoadRequest) -> RunRequest:
    """Read and check a program and all documents that it needs to run.

    Raises:
        DiagnosticsError: A document has errors; its ``diagnostics`` list them.
        UsageError: There is no such document, or the documents do not fit each other.
    """
    return request.read(request.program)
