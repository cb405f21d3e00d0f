"""Documents as typed data, to read, change, write and identify.

``load`` and ``check`` read files; ``cbdsl.api.shipped`` reads the documents of the package.
"""

from __future__ import annotations

from cbdsl.documents.calibration import CalibratedCamera, CalibrationDocument, CalibrationOrigin
from cbdsl.documents.catalog import (
    AffordanceSection,
    CatalogDocument,
    CatalogProvenance,
    StepColumns,
)
from cbdsl.documents.document_digest import digest
from cbdsl.documents.form import BoxForm
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.documents.model import Gaussian, Kernel, ModelDocument
from cbdsl.documents.policy import Curve, PolicyDocument, Provenance
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import Camera, Correction, RobotDocument
from cbdsl.documents.schema import SchemaDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.storage.atomic_file import make_room, require_unlinked, write_text
from cbdsl.storage.digest import digest_of_bytes, digest_of_text
from cbdsl.yaml_text.writer import write

__all__ = [
    "AffordanceSection", "BoxForm", "CalibratedCamera", "CalibrationDocument",
    "CalibrationOrigin", "Camera", "CatalogDocument", "CatalogProvenance", "Correction",
    "Curve", "Gaussian", "Kernel", "MetaCatalogDocument", "ModelDocument", "PolicyDocument",
    "ProgramDocument", "Provenance", "RobotDocument", "SchemaDocument", "StageDocument",
    "StepColumns", "digest", "digest_of_bytes", "digest_of_text", "make_room",
    "require_unlinked", "write", "write_text",
]  # fmt: skip
