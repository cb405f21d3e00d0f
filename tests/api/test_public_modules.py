"""Modules for users below the verbs: each public name exists, is documented, and is in the docs."""

from __future__ import annotations

import inspect
import subprocess
import sys
from importlib import import_module

import pytest

import cbdsl
from cbdsl.api.learning import Experience
from cbdsl.api.shipped import shipped_document, shipped_names, shipped_program
from tests.conftest import ROOT

#: Modules whose ``__all__`` is public.
MODULES = (
    "cbdsl.api.control",
    "cbdsl.api.documents",
    "cbdsl.api.drawing",
    "cbdsl.api.learning",
    "cbdsl.api.program",
    "cbdsl.api.sensing",
    "cbdsl.api.trials",
)
#: Modules of the contract of extensions, one for each entry-point group.
GROUPS = tuple(
    f"cbdsl.extend.{file.stem}"
    for file in sorted((ROOT / "cbdsl" / "extend").glob("*.py"))
    if file.stem not in ("__init__", "lazy_names")
)
PAGE = ROOT / "docs" / "how_to" / "use_from_python.md"


@pytest.mark.parametrize("name", MODULES)
def test_public_module_names_exist_and_are_documented(name: str) -> None:
    module = import_module(name)
    assert f"`{name}`" in PAGE.read_text("utf-8")
    for public in module.__all__:
        value = getattr(module, public)
        if inspect.isclass(value) or inspect.isfunction(value):
            assert inspect.getdoc(value), f"{name}.{public} has no docstring"


@pytest.mark.parametrize("name", GROUPS)
def test_contract_names_exist_and_are_documented(name: str) -> None:
    module = import_module(name)
    noun = name.rpartition(".")[2]
    plural = f"{noun[:-2]}es" if noun.endswith("is") else f"{noun}s"
    group, test = f"cbdsl.{plural}", f"cbdsl.extend.contract.test_{noun}"
    assert group in str(module.__doc__) and test in str(module.__doc__)
    assert import_module(test)
    for public in module.__all__:
        value = getattr(module, public)
        if (inspect.isclass(value) or inspect.isfunction(value)) and "cbdsl" in value.__module__:
            assert inspect.getdoc(value), f"{name}.{public} has no docstring"
    with pytest.raises(AttributeError, match="has no attribute 'absent'"):
        module.absent  # noqa: B018


def test_contract_of_drivers_and_exports_imports_no_numpy() -> None:
    script = (
        "import sys; from cbdsl.extend.driver import DriverKind; "
        "from cbdsl.extend.export import Export; print('numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "False\n", done.stderr


def test_public_names_belong_to_one_module() -> None:
    names = [public for name in MODULES for public in import_module(name).__all__]
    assert len(names) == len(set(names))


def test_shipped_program_ignores_documents_in_the_working_folder(
    tmp_path: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    from pathlib import Path

    folder = Path(str(tmp_path))
    monkeypatch.chdir(folder)
    text = (ROOT / "programs" / "searchtrack.yaml").read_text("utf-8")
    (folder / "searchtrack.yaml").write_text(text.replace("$eyes.uniform", "hed"), "utf-8")
    with pytest.raises(cbdsl.DiagnosticsError):
        cbdsl.load("searchtrack")
    request = shipped_program("searchtrack")
    assert request.program.name == "searchtrack" and len(request.digest.sha256) == 64


def test_shipped_document_of_a_missing_name_raises_lookup_error() -> None:
    from cbdsl.api.documents import StageDocument

    assert "stacking" in shipped_names(StageDocument)
    with pytest.raises(LookupError, match="'nowhere' is not shipped"):
        shipped_document(StageDocument, "nowhere")


def test_allocations_of_a_program_contain_its_own_first() -> None:
    from cbdsl.api.allocation import allocated, allocations

    request = shipped_program("reachtouch")
    names = [*allocations(request)]
    program = allocated(request, "reachtouch")
    assert names[0] == "right_arm" and {"left_arm", "reachtouch_bimanual"} <= {*names}
    assert program.schema is not None and {*program.schema.allocations} == {*names}


def test_exchanged_member_of_another_kind_is_refused_with_its_name() -> None:
    from cbdsl.api.allocation import exchanged

    request = shipped_program("reachtouch")
    assert exchanged(request, "touch", "tactileprobe").name == "reachtouch"
    with pytest.raises(cbdsl.UsageError, match="'searchtrack' cannot take the place of 'touch'"):
        exchanged(request, "touch", "searchtrack")


def test_experience_sums_its_rewards() -> None:
    assert Experience("stage", 0, (), {}, 0, 0.0).reward == 0
