"""The policy document: which action follows which state, apart from the program it serves."""

from typing import Literal

from cbdsl.documents.document import Document, Name


class PolicyDocument(Document):
    """A policy that can stand in for the one written in its program."""

    kind: Literal["policy"]
    """Says that this document is a policy."""
    program: Name
    """Program that it serves."""
    predicates: tuple[str, ...]
    """The controllers and programs whose predicates make up a state, in order."""
    policy: dict[str, str]
    """Action by state."""
