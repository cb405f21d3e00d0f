"""Safety net around the checks of a document: a check that fails is a diagnostic."""

from __future__ import annotations

import os
from pathlib import Path

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostic import FAILED_CHECK, Diagnostic, Place
from cbdsl.diagnostics.wording import diagnose
from cbdsl.types.registry import PluginError


def check_safely(path: Path, session: Session) -> list[Diagnostic]:
    """Return all diagnostics in a document; a check that raises is one of them.

    With ``CB_TRACEBACK`` in the environment the exception goes on, so that it can be located.
    """
    try:
        return check_document(path, session)
    except Exception as error:
        if os.environ.get("CB_TRACEBACK"):
            raise
        is_named = isinstance(error, PluginError)  # its message names the package and the fault
        reason = str(error) if is_named else f"{type(error).__name__}: {error}"
        return [diagnose(FAILED_CHECK, Place(str(path)), reason=reason)]
