"""Contract of formats of robot models: files that are none are refused by name."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.urdf import UrdfError
from cbdsl.scaffold.model_format import MODEL_FORMATS


@pytest.mark.parametrize("data", [b"", b"<", b"\xff\xfe", b"<robot>" * 5_000, bytes(range(256))])
@pytest.mark.parametrize("name", MODEL_FORMATS.usable_names())
def test_file_that_is_no_model_is_refused_by_name(name: str, data: bytes, tmp_path: Path) -> None:
    file = tmp_path / "any.model"
    file.write_bytes(data)
    with pytest.raises(UrdfError, match=r"any\.model"):
        MODEL_FORMATS.get(name).converted(file, "any", {}, PackageFolders({}, [], file))
