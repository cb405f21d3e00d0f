"""Where knowledge goes: policies and models find each other by name."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.yaml_text.library import Library
from tests.training.toy import take


@pytest.mark.parametrize(
    ("policy", "model"),
    [
        ("here/looking.yaml", "here/looking_head.yaml"),
        ("knowledge/policies/looking.yaml", "knowledge/models/looking_head.yaml"),
    ],
)
def test_written_policy_and_models_are_found_by_name(
    tmp_path: Path, policy: str, model: str
) -> None:
    path = tmp_path / policy
    path.parent.mkdir(parents=True)
    take(path, 3)
    assert (tmp_path / model).is_file()
    library = Library(tmp_path)
    found = library.find(ModelDocument, "looking_head", path)
    assert found is not None and found.resolve() == tmp_path / model
    in_library = library.find(PolicyDocument, "looking")
    assert (in_library is not None) == ("policies" in policy)
