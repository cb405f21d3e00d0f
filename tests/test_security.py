"""SECURITY.md: each statement has a test, which exists."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tests.conftest import ROOT

# Words of a statement, and the test that holds it.
STATEMENTS = {
    "runs nothing of a document": "fuzz/test_corpus.py:test_what_is_kept_is_read",
    "hides no finding of other documents": "checking/test_odd_names.py:"
    "test_validate_with_an_odd_name_reports_other_documents_too",
    "XML without entities": "test_reader_sizes.py:test_urdf_beyond_its_bounds_is_refused",
    "xacro only by its name": "cli/test_model_source.py:"
    "test_new_robot_from_xacro_by_another_name_needs_the_option",
    "expressions are interpreted": "robot/xacro/test_expression.py:"
    "test_evaluate_anything_else_is_refused",
    "environment is not read": "robot/xacro/test_expansion.py:"
    "test_expand_unbounded_model_is_refused",
    "MuJoCo compiles it in a process": "cli/test_model_source.py:"
    "test_new_robot_from_mjcf_that_takes_long_ends",
    "without pickles": "fuzz/test_corpus.py:test_what_is_kept_is_read",
    "meshes are shown only from": "reporting/test_model.py:"
    "test_read_links_of_a_recording_shows_no_mesh_from_elsewhere",
    "are written as escapes": "cli/test_legible_output.py:"
    "test_command_on_harmful_names_and_texts_prints_legible_text",
    "warns of a plain scheduler": "cli/test_workers.py:"
    "test_a_plain_scheduler_elsewhere_is_warned_of",
    "another user can have written": "test_security.py:"
    "test_machine_code_that_others_can_write_is_not_read",
    "1,000 joints in a chain": "test_reader_sizes.py:test_urdf_beyond_its_bounds_is_refused",
    "5 million steps": "robot/xacro/test_expansion.py:test_expand_unbounded_model_is_refused",
    "200,000 triangles": "test_reader_sizes.py:"
    "test_mesh_of_too_many_triangles_is_refused_while_it_is_read",
    "10 s of processor time": "cli/test_model_source.py:"
    "test_new_robot_from_mjcf_that_takes_long_ends",
    "1 GB of arrays": "test_reader_sizes.py:test_recording_that_unpacks_to_much_is_refused_before",
    "in proportion to size": "test_reader_sizes.py:"
    "test_reader_of_twice_the_size_takes_little_more_than_twice_the_time",
    "answers only to that name": "reporting/live/test_server.py:"
    "test_other_hosts_and_origins_are_refused",
    "only on requests with a token": "reporting/live/test_server.py:"
    "test_nothing_is_done_without_the_token",
    "listen on no port": "training/test_local_workers.py:"
    "test_run_on_workers_listens_nowhere_and_denies_other_users",
    "import nothing from the current folder": "training/test_local_workers.py:"
    "test_learn_with_workers_imports_nothing_from_the_current_folder",
    "`halt` is called whenever": "backends/test_backend_calls.py:"
    "test_backend_that_raises_is_halted_and_named",
    "the robot may still move": "backends/test_backend_calls.py:"
    "test_halt_that_raises_keeps_the_first_cause_and_the_recording",
}


@pytest.mark.parametrize("words", STATEMENTS)
def test_statement_is_on_the_page_and_its_test_exists(words: str) -> None:
    assert words in (ROOT / "SECURITY.md").read_text("utf-8")
    file, _, name = STATEMENTS[words].partition(":")
    tree = ast.parse((ROOT / "tests" / file).read_text("utf-8"))
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    assert name in {function.name for function in functions}


def test_bounds_on_the_page_are_those_of_the_readers() -> None:
    from cbdsl.reporting import recorded
    from cbdsl.robot import robot_xml, triangles, urdf_reader
    from cbdsl.robot.mjcf import bounded_conversion
    from cbdsl.robot.xacro import budget
    from cbdsl.yaml_text import composer

    page = (ROOT / "SECURITY.md").read_text("utf-8")
    for words in (
        f"{composer.MOST_CHARACTERS:,} characters, {composer.LONGEST_TEXT:,} in one text",
        f"{composer.LONGEST_KEY:,} in one key, {composer.MOST_NODES:,} values, "
        f"{composer.DEEPEST} levels",
        f"{robot_xml.MOST_BYTES // 10**6} MB, {urdf_reader._MOST['link']:,} links, "
        f"{urdf_reader._DEEPEST:,} joints",
        f"{budget._MOST_STEPS // 10**6} million steps, values of {budget.MOST_PARTS:,} parts",
        f"{triangles.MOST_BYTES // 10**6} MB, {triangles.MOST:,} triangles",
        f"{bounded_conversion._MOST_SECONDS} s of processor time, "
        f"{bounded_conversion._MOST_BYTES // 10**9} GB",
        f"{recorded._MOST_ARRAY_BYTES // 10**9} GB of arrays",
    ):
        assert words in page


def test_machine_code_that_others_can_write_is_not_read(tmp_path: Path) -> None:
    from cbdsl.numeric.kernel_cache import _is_own

    file = tmp_path / "code.nbc"
    file.write_bytes(b"")
    tmp_path.chmod(0o755)
    assert _is_own(file)
    file.chmod(0o666)
    assert not _is_own(file)
    file.chmod(0o644)
    tmp_path.chmod(0o777)
    assert not _is_own(file)


def test_dependencies_have_upper_bounds() -> None:
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    users = ("kinematic", "bullet", "mujoco", "formats", "learn", "editor", "gym", "trees", "mcap")
    names = [*project["dependencies"]]
    for extra in users:
        names += project["optional-dependencies"][extra]
    open_ended = [name for name in names if not name.startswith("cbdsl[") and "<" not in name]
    assert not [name for name in open_ended if not re.search("==", name)]
