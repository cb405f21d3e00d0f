"""Section with a file whose content counts, such as a mesh or a network."""

from pathlib import Path
from typing import Annotated, ClassVar, Self

from pydantic import (
    Field,
    FieldSerializationInfo,
    PrivateAttr,
    ValidationInfo,
    field_serializer,
    model_validator,
)

from cbdsl.documents.document import Section
from cbdsl.storage.contents import contents, is_file
from cbdsl.storage.digest import digest_of_bytes

FileName = Annotated[str, Field(min_length=1)]


class FileSection(Section):
    """Section that names a file, whose content counts in digests, regardless of its path."""

    most_bytes: ClassVar[int] = 64_000_000
    """Size above which readers refuse the file."""

    file: FileName
    """Path of the file, relative to the document's folder."""

    _folder: Path = PrivateAttr(default=Path())

    @model_validator(mode="after")
    def _is_in_a_folder(self, info: ValidationInfo) -> Self:
        # A document does not hold its own path, so that its folder comes with the validation.
        if info.context is not None:
            self._folder = info.context["folder"]
        return self

    @property
    def path(self) -> Path:
        """Path of the file."""
        return self._folder / self.file

    @field_serializer("file")
    def _by_its_content(self, file: str, info: FieldSerializationInfo) -> str:
        # Knowledge learned with a file is valid for its content.
        if info.context is None or not is_file(self.path):
            return file
        try:
            return digest_of_bytes(contents(self.path, self.most_bytes))
        except OSError:
            return file  # as readers of the file report
