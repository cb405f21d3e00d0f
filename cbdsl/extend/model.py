"""Formats of robot models, for the entry-point group ``cbdsl.models``.

An entry is a ``ModelFormat``, whose function returns the URDF of a file. It runs no code of the
file, and its work is bounded. ``UrdfError`` names the file and the reason of a refusal. The
contract test is ``cbdsl.extend.contract.test_model``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.extend.lazy_names import lazy_names

if TYPE_CHECKING:
    from cbdsl.backends.distributions import require_unmixed
    from cbdsl.diagnostics.nearest import suggestion
    from cbdsl.robot.package_folders import PackageFolders
    from cbdsl.robot.robot_xml import MOST_BYTES, refuse_entities, xml_root
    from cbdsl.robot.urdf import UrdfError
    from cbdsl.scaffold.model_format import ConvertedModel, ModelFormat
    from cbdsl.storage.contents import contents

__all__ = [
    "MOST_BYTES", "ConvertedModel", "ModelFormat", "PackageFolders", "UrdfError", "contents",
    "refuse_entities", "require_unmixed", "suggestion", "xml_root",
]  # fmt: skip

__getattr__ = lazy_names(__file__)
