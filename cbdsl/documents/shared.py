"""The document of shared controllers, which programs take up by name."""

from typing import Annotated, Any, Literal

from pydantic import Field
from pydantic_core.core_schema import str_schema

from cbdsl.documents.document import Document, Name, ValueSchema
from cbdsl.documents.kind import Kind

_NAME = r"[A-Za-z][A-Za-z0-9_]*"

Signature = Annotated[
    str, ValueSchema(str_schema(pattern=rf"^{_NAME}(\({_NAME}(, ?{_NAME})*\))?$"))
]
"""A name with its parameters, such as `go_home(arm)`."""


class SharedDocument(Document):
    """Controllers, compositions and conditions that programs take up and call by name."""

    kind: Literal["shared"]
    """Kind of this document: shared controllers."""
    robot: Name
    """Robot that it is checked with; programs for other robots may take it up, too."""
    parameters: dict[Name, str] = {}
    """Parameters of the signatures, each with the value that it is checked with."""
    controllers: dict[Signature, Annotated[dict[Name, Any], Field(min_length=1)] | str] = {}
    """Triples or compositions, as in a program, by signature: `go_home(arm)`. A program calls them
    with its values: `go_home($arm)`."""
    conditions: dict[Signature, str] = {}
    """Comparisons, as in a program, by signature: `loaded(hand, force)`."""


SHARED = Kind(
    SharedDocument,
    folder="programs/shared",
    checker="cbdsl.checking.rules.shared_documents:check_shared",
    unknown="CB628",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown"},
)
