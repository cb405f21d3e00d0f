"""Stand-ins for the person who sets up the stage of a real robot and releases it."""

from __future__ import annotations

from cbdsl.extend.backend import BackendError


class RefusingPerson:
    """Stand-in that refuses: a program alone never moves a real robot."""

    def confirm(self, text: str, question: str, *, released: bool) -> bool:
        """Refuse.

        Raises:
            BackendError: Always.
        """
        raise BackendError(f"a person has to confirm '{question}' before a real robot moves")


class Consent:
    """Consent in advance, as by ``--yes``; never to the release of a held robot."""

    def confirm(self, text: str, question: str, *, released: bool) -> bool:
        """Agree to questions that a consent in advance may answer."""
        return released
