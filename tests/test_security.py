"""SECURITY.md: each sentence has tests, which exist, or a reason for having none."""

from __future__ import annotations

import ast
import json
import pickle
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.errors import UsageError
from cbdsl.yaml_text import composer
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT
from tests.test_reader_sizes import recording

_BACKEND = "backends/test_backend_calls.py:"
_SOURCE = "scaffold/test_model_source.py:"
_SIZES = "test_reader_sizes.py:"
_SERVER = "reporting/live/test_page_server.py:"
_GUARD = "../distributions/cbdsl-ros2/tests/test_guard.py:"
_WATCHDOG = "../distributions/cbdsl-drive/tests/test_watchdog.py:"
_MCP = "../distributions/cbdsl-mcp/tests/test_server.py:"
_NETWORKS = "../distributions/cbdsl-onnx/tests/test_checker.py:"
_WORKERS = "training/workers/test_local_workers.py:"
_BOUNDS = "test_security.py:test_bounds_on_the_page_are_those_of_the_readers"
_HERE = "test_security.py:"

#: Sentences of the page, and the tests of each.
STATEMENTS: dict[str, tuple[str, ...]] = {
    "`tests/test_security.py` names the tests of each of these sentences.": (
        f"{_HERE}test_sentence_of_the_page_has_tests_or_a_reason",
    ),
    "`cb validate` runs nothing of a document, writes nothing, and uses no network": (
        f"{_HERE}test_validate_of_any_document_writes_runs_and_connects_nothing",
    ),
    "a name that no file can have is a finding, and hides no finding of other documents": (
        "checking/test_odd_names.py:test_validate_with_an_odd_name_reports_other_documents_too",
    ),
    "they are read as XML without entities": (
        f"{_SIZES}test_urdf_beyond_its_bounds_is_refused",
        f"{_HERE}test_semantic_groups_with_entities_are_refused",
    ),
    "`cb validate` searches their bytes for damage, without a native reader": (
        "backends/test_damaged_meshes.py:test_robot_with_damaged_mesh_is_refused_by_the_checker_and_each_engine",
        f"{_HERE}test_validate_of_a_mesh_of_a_robot_loads_no_native_reader",
    ),
    "a file is xacro only by its name (`.xacro`) or by `--xacro`": (
        f"{_SOURCE}test_new_robot_from_xacro_by_another_name_needs_the_option",
        f"{_SOURCE}test_new_robot_from_groups_in_xacro_by_another_name_expands_nothing",
    ),
    "expressions are interpreted": (
        "../distributions/cbdsl-formats/tests/test_xacro_expression.py:test_evaluate_any_text_returns_plain_value_or_raises",
    ),
    "they call only the functions of xacro's documentation, and reach no attribute that begins "
    "with `_`": (
        "../distributions/cbdsl-formats/tests/test_xacro_expression.py:test_evaluate_anything_else_is_refused",
        "../distributions/cbdsl-formats/tests/test_expansion.py:test_expand_expression_that_reaches_python_is_refused",
    ),
    "the environment is not read": (
        "../distributions/cbdsl-formats/tests/test_expansion.py:test_expand_unbounded_model_is_refused",
    ),
    "MuJoCo compiles it in a process of its own": (
        f"{_SOURCE}test_new_robot_from_mjcf_that_takes_long_ends",
    ),
    "onnxruntime runs them once, on zeros, in such a process": (
        f"{_NETWORKS}test_check_of_a_network_runs_it_in_another_process",
    ),
    "`cb replay` and `cb report` read JSON and arrays without pickles": (
        f"{_HERE}test_recording_with_a_pickle_is_refused_and_runs_nothing",
    ),
    "meshes are shown only from the current folder, the installation, and `ROS_PACKAGE_PATH`": (
        "reporting/test_drawn_links.py:test_read_links_of_a_recording_shows_no_mesh_from_elsewhere",
    ),
    "a file is written through a symbolic link only if its name was given": (
        "cli/test_planted_links.py:test_no_command_writes_through_a_planted_link",
        "cli/test_planted_links.py:test_fmt_follows_a_link_that_the_user_names",
    ),
    "a link in a derived name is refused": (
        "cli/test_planted_links.py:test_no_command_writes_through_a_planted_link",
        "cli/test_planted_links.py:test_command_for_a_folder_leaves_linked_files",
    ),
    "a journal is a regular file of at most 1 GB": (
        "storage/test_journal.py:test_journal_in_the_place_of_something_else_is_refused",
    ),
    "a pipe or device in its place is refused": (
        "storage/test_journal.py:test_journal_in_the_place_of_something_else_is_refused",
    ),
    "characters that move or change a terminal are written as escapes": (
        "cli/process/test_legible_output.py:test_command_on_harmful_names_and_texts_prints_legible_text",
    ),
    "an installed package with entry points of `cbdsl` runs as part of `cb`": (
        "plugins/test_documents.py:test_plugin_document_is_found_by_name_without_diagnostics",
    ),
    "`cb run` and `cb replay` hand URDF and meshes to PyBullet, Pinocchio and MuJoCo, native code "
    "that is not made for hostile files": (
        "cli/test_main.py:test_validating_imports_nothing_heavy",
    ),
    "absolute paths and `..` are allowed, so that models can share meshes": (
        f"{_HERE}test_mesh_of_a_stage_by_any_path_is_read_as_a_mesh_alone",
    ),
    "a named file is read as a mesh or model alone": (
        f"{_HERE}test_mesh_of_a_stage_by_any_path_is_read_as_a_mesh_alone",
    ),
    "Dask sends code both ways": (
        "cli/arguments/test_workers.py:test_plain_scheduler_on_another_machine_gives_a_warning",
    ),
    "use [TLS](docs/how_to/learn_on_a_cluster.md#on-a-cluster) between machines.": (
        "test_docs.py:test_links_of_a_page_lead_to_files",
    ),
    "`cb` warns of a plain scheduler that is not on this machine": (
        "cli/arguments/test_workers.py:test_plain_scheduler_on_another_machine_gives_a_warning",
    ),
    "DDS authenticates none of them": (
        "../distributions/cbdsl-ros2/tests/test_follower.py:test_follower_refuses_a_second_writer",
    ),
    "a robot is held when another commander writes to its topic, or moves its joints": (
        "../distributions/cbdsl-ros2/tests/test_follower.py:test_follower_refuses_a_second_writer",
        "../distributions/cbdsl-drive/tests/test_backend.py:test_held_robot_is_released_by_a_person_only",
        "../distributions/cbdsl-drive/tests/test_backend.py:test_robot_that_another_controller_carries_is_held",
    ),
    "they are kept below the user's folder of caches": (
        "numeric/test_kernel_cache.py:test_folder_is_below_the_users_caches",
    ),
    "a file that another user can have written is not read": (
        f"{_HERE}test_machine_code_that_others_can_write_is_not_read",
    ),
    "settings of numba in the current folder are not read": (
        f"{_HERE}test_settings_of_numba_in_the_current_folder_are_not_read",
    ),
    "256,000 characters, 10,000 in one text, 1,000 in one key, 10,000 values, 2,000 in one list or "
    "mapping, 64 levels": (_BOUNDS, f"{_HERE}test_document_beyond_a_bound_is_refused"),
    "4 MB, 10,000 links, 1,000 joints in a chain": (
        _BOUNDS,
        f"{_SIZES}test_urdf_beyond_its_bounds_is_refused",
    ),
    "5 million steps, values of 10,000 parts, texts of a million characters": (
        _BOUNDS,
        "../distributions/cbdsl-formats/tests/test_expansion.py:test_expand_unbounded_model_is_refused",
        "../distributions/cbdsl-formats/tests/test_xacro_expression.py:test_evaluate_large_value_is_refused_before_it_is_made",
    ),
    "5 s without computing, for a file that gives nothing": (
        f"{_SOURCE}test_new_robot_from_mjcf_that_names_a_pipe_ends",
    ),
    "20 MB, 200,000 triangles": (
        _BOUNDS,
        f"{_SIZES}test_mesh_of_too_many_triangles_is_refused_while_it_is_read",
        f"{_SIZES}test_sparse_mesh_is_refused_before_it_is_read",
    ),
    "100 MB each, and the smallest of 100 MB together are read": (
        _BOUNDS,
        "robot/meshes/test_mesh_damage.py:test_mesh_damage_of_file_that_is_too_large_opens_nothing",
        "robot/meshes/test_mesh_damage.py:"
        "test_damaged_meshes_of_large_model_reads_the_smallest_files",
    ),
    "10 s of processor time, 3 GB": (
        _BOUNDS,
        f"{_SOURCE}test_new_robot_from_mjcf_that_takes_long_ends",
        f"{_SOURCE}test_new_robot_from_mjcf_with_many_copies_is_refused",
    ),
    "500 MB, 20 s, 4 GB": (
        _BOUNDS,
        f"{_NETWORKS}test_check_of_a_huge_model_reads_none_of_it",
        f"{_NETWORKS}test_check_of_a_model_that_asks_for_much_ends",
    ),
    "1 GB of arrays, checked before they are unpacked": (
        _BOUNDS,
        f"{_SIZES}test_recording_that_unpacks_to_much_is_refused_before",
    ),
    "Time grows in proportion to size for every reader.": (
        f"{_SIZES}test_reader_of_twice_the_size_takes_little_more_than_twice_the_time",
    ),
    "A crash, a hang, or a traceback of `cb validate` is a fault.": (
        "test_broken_files.py:test_validate_of_a_thousand_broken_files_is_bounded",
        "cli/test_validate_fuzz.py:test_any_mutation_is_reported_in_any_format",
    ),
    "`cb` opens no port, except for `--live`, `--scheduler`, and robots that speak ROS 2.": (
        f"{_HERE}test_commands_without_a_network_listen_nowhere",
        f"{_WORKERS}test_run_on_workers_listens_nowhere_and_denies_other_users",
    ),
    "`--live` serves a page at 127.0.0.1.": (
        f"{_SERVER}test_server_listens_on_the_loopback_address",
    ),
    "It answers only to that name and `localhost`, against DNS rebinding, and to pages of its own "
    "origin.": (
        f"{_SERVER}test_foreign_hosts_and_origins_are_refused",
        f"{_SERVER}test_localhost_is_this_machine_too",
    ),
    "It acts only on requests with a token that is in the page.": (
        f"{_SERVER}test_request_without_the_token_is_refused",
        f"{_SERVER}test_page_has_an_unguessable_token",
    ),
    "The address of the page holds a secret, without which other users of the same machine cannot "
    "open it.": (f"{_SERVER}test_page_without_the_key_of_its_address_is_refused",),
    "A browser that `cb` opens on a screen has the address on its command line.": (
        "cli/episodes/test_live.py:test_browser_is_opened_only_where_there_is_a_screen",
    ),
    "The page writes no file: the browser downloads a composed program.": (
        "reporting/live/test_requests.py:test_changes_are_made_and_saved",
        f"{_HERE}test_module_of_the_live_page_writes_no_file",
    ),
    "Workers of `--workers` listen on no port: pipes of the command alone reach them.": (
        f"{_WORKERS}test_run_on_workers_listens_nowhere_and_denies_other_users",
    ),
    "They import nothing from the current folder.": (
        f"{_WORKERS}test_learn_with_workers_imports_nothing_from_the_current_folder",
    ),
    "They end with the command.": (f"{_WORKERS}test_interrupt_while_workers_begin_is_one_line",),
    "Tools of `cb mcp` run `list`, `show`, `validate`, `explain`, `run`, `why`, `compare`, `learn` "
    "and `explore`, and no other program.": (f"{_MCP}test_tools_run_commands_of_cb_alone",),
    "Files that a client names are in the folder of `--folder`, also behind links.": (
        f"{_MCP}test_server_refuses_arguments_beyond_its_folder_and_simulators",
        f"{_MCP}test_folder_is_not_left_by_a_link",
    ),
    "No module of the folder is imported.": (f"{_MCP}test_server_imports_nothing_from_its_folder",),
    "Only simulators run.": (
        f"{_MCP}test_server_refuses_arguments_beyond_its_folder_and_simulators",
    ),
    "With `--allow-hardware`, programs for that robot also run on a real one, after a yes of the "
    "person at the client to each run.": (
        f"{_MCP}test_real_robot_does_not_move_without_a_person",
        f"{_MCP}test_robot_of_a_name_is_that_of_the_folder",
        f"{_MCP}test_program_that_changes_robots_during_the_question_is_refused",
    ),
    "The client passes the question on, so that a client that is not trusted can answer it.": (
        f"{_MCP}test_yes_of_a_client_starts_the_run",
    ),
    "A dead or silent button of `stop` holds a robot after `stop_deadline`.": (
        "../distributions/cbdsl-drive/tests/test_stop_watch.py:test_stop_watch_finds_a_button_that_falls_silent",
        "../distributions/cbdsl-drive/tests/test_stop_watch.py:test_stop_watch_finds_a_button_that_ends",
    ),
    "With `stop_repeats: false` it is unnoticed for up to 20 s, and pressing it has no effect.": (
        "../distributions/cbdsl-drive/tests/test_stop_watch.py:test_stop_watch_finds_a_button_that_falls_silent",
    ),
    "A watchdog waits after a program that ended its episode at rest, and takes references within"
    " `start` of the robot from the next one.": (
        f"{_WATCHDOG}test_watchdog_keeps_limits_and_waits_at_a_word_only",
        f"{_WATCHDOG}test_watchdog_that_waits_refuses_references_far_from_the_robot",
        f"{_WATCHDOG}test_watchdog_begins_at_a_robot_that_was_moved_while_it_waited",
        "../distributions/cbdsl-drive/tests/test_backend.py:test_program_that_halts_says_so_at_rest",
    ),
    "It stops if a program falls silent otherwise, or if a second one commands.": (
        f"{_WATCHDOG}test_watchdog_waits_for_a_computing_program_and_stops_one_that_hangs_at_rest",
        f"{_WATCHDOG}test_watchdog_stops_a_program_that_is_killed_at_any_speed",
        "../distributions/cbdsl-drive/tests/test_backend.py:test_program_that_a_fault_holds_says_nothing",
        f"{_GUARD}test_guard_stops_beside_another_commander",
        f"{_GUARD}test_guard_waits_for_the_next_episode_without_a_rival",
    ),
    "`halt` is called whenever an episode cannot begin or go on.": (
        f"{_BACKEND}test_backend_that_raises_is_halted_and_named",
        f"{_BACKEND}test_backend_that_is_interrupted_is_halted",
    ),
    "If it fails, the first cause is reported, with a warning that the robot may still move.": (
        f"{_BACKEND}test_halt_that_raises_keeps_the_first_cause_and_the_recording",
    ),
}

#: Sentences on the purpose of the software, which no code can fulfil or break.
DECLARATIONS = (
    "`cbdsl` is a research tool.",
    "Its speed limits, deadlines and `halt` are no safety functions.",
    "A real robot needs the measures of its own safety standard, independent of this software.",
    "[Faults that were tried](docs/how_to/drive_a_real_robot.md#faults-that-were-tried) has kinds "
    "and times.",
)


def page() -> str:
    return (ROOT / "SECURITY.md").read_text("utf-8")


def sentences(text: str) -> Iterator[str]:
    """Yield the sentences of paragraphs and of the last cells of tables, from "Trust" on."""
    _, _, rest = text.partition("\n## Trust\n")
    for block in rest.split("\n\n"):
        lines = block.strip().splitlines()
        if block.lstrip().startswith("|"):
            cells = [line.strip("| ").split(" | ")[-1] for line in lines[2:]]
        elif block.lstrip().startswith("#"):
            continue
        else:
            cells = [" ".join(lines)]
        for cell in cells:
            yield from (each.strip() for each in re.split(r"(?<=\.)\s+|;\s+", cell) if each.strip())


def test_sentence_of_the_page_has_tests_or_a_reason() -> None:
    found = list(sentences(page()))
    assert len(found) > 40
    assert sorted(found) == sorted([*STATEMENTS, *DECLARATIONS])


def test_sentences_of_a_changed_page_have_no_tests() -> None:
    changed = page().replace("the environment is not read", "the environment is never read")
    assert set(sentences(changed)) - STATEMENTS.keys() - set(DECLARATIONS) == {
        "the environment is never read"
    }


@cache
def functions(file: Path) -> frozenset[str]:
    tree = ast.parse(file.read_text("utf-8"))
    return frozenset(node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))


@pytest.mark.parametrize("sentence", STATEMENTS)
def test_sentence_has_tests_that_exist(sentence: str) -> None:
    assert STATEMENTS[sentence]
    for each in STATEMENTS[sentence]:
        file, _, name = each.partition(":")
        assert name in functions(ROOT / "tests" / file)


# Audit events of a command that writes, runs or connects, and files that it opens.
_AUDITED = """
import json, os, sys
events = []
def note(event, args):
    if event == "open":
        path, mode, flags = args
        is_written = isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        if isinstance(path, (str, bytes)):
            events.append(["write" if is_written else "read", os.fsdecode(path)])
    elif event.split(".")[0] in ("socket", "subprocess", "shutil", "ftplib", "urllib") or event in (
        "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.remove", "os.rename", "os.mkdir",
        "os.rmdir", "os.truncate", "os.link", "os.symlink", "os.chmod", "pty.spawn",
    ):
        events.append([event, str(args)])
from cbdsl.cli.main import main
sys.addaudithook(note)
try:
    main()
except SystemExit as end:
    print(json.dumps({"code": end.code, "events": events}), file=sys.stderr)
"""


def audited(folder: Path, *words: str) -> list[tuple[str, str]]:
    """Return the audit events of a command in a folder."""
    done = subprocess.run(
        [sys.executable, "-B", "-c", _AUDITED, *words], cwd=folder, capture_output=True, text=True
    )
    told = json.loads(done.stderr.splitlines()[-1])
    return [(event, detail) for event, detail in told["events"]]


def test_validate_of_any_document_writes_runs_and_connects_nothing(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "tests" / "checking" / "bad", tmp_path / "bad")
    write_robot_with_mesh(tmp_path)
    events = audited(tmp_path, "validate", ".")
    assert any(file.endswith("panda.urdf") for event, file in events if event == "read")
    assert [each for each in events if each[0] != "read"] == []


def write_robot_with_mesh(folder: Path) -> None:
    """Write the shipped Panda with a mesh of no triangles."""
    mesh = '<mesh filename="tip.stl"/>'
    urdf = (ROOT / "robots" / "panda.urdf").read_text("utf-8")
    urdf = urdf.replace("</link>", f"<visual><geometry>{mesh}</geometry></visual></link>")
    (folder / "panda.urdf").write_text(urdf, encoding="utf-8")
    (folder / "tip.stl").write_bytes(bytes(84))
    shutil.copy(ROOT / "robots" / "panda.yaml", folder)


_VALIDATE = "import sys; sys.argv[1:] = ['validate', '.']; from cbdsl.cli.main import main; main()"


def test_validate_of_a_mesh_of_a_robot_loads_no_native_reader(tmp_path: Path) -> None:
    write_robot_with_mesh(tmp_path)
    done = subprocess.run(
        [sys.executable, "-B", "-X", "importtime", "-c", _VALIDATE],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert done.returncode == 1 and "CB366 mesh 'tip.stl'" in done.stdout
    assert "cbdsl.robot.meshes.mesh_damage" in imported
    assert imported.isdisjoint({"numpy", "coal", "pinocchio", "pybullet", "mujoco"})


def test_commands_without_a_network_listen_nowhere(tmp_path: Path) -> None:
    for words in (
        ("run", "searchtrack", "--backend", "kinematic", "--record", "kept"),
        ("replay", "kept", "--out", "page.html"),
        ("show", "program", "reachtouch"),
        ("list",),
    ):
        events = audited(tmp_path, *words)
        assert not [each for each in events if each[0] in ("socket.bind", "socket.connect")]
        assert ("write" in {event for event, _ in events}) == (words[0] in ("run", "replay"))


def test_semantic_groups_with_entities_are_refused(tmp_path: Path) -> None:
    from cbdsl.robot.srdf import parse_srdf
    from cbdsl.robot.urdf import UrdfError

    text = "<!DOCTYPE r [<!ENTITY a SYSTEM 'file:///etc/passwd'>]><robot name='r'>&a;</robot>"
    with pytest.raises(UrdfError, match="declares XML entities"):
        parse_srdf(text, tmp_path / "any.srdf")


class Harmful:
    """Object that creates a file when it is unpickled."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def __reduce__(self) -> tuple[object, ...]:
        return (Path.touch, (self._file,))


def test_recording_with_a_pickle_is_refused_and_runs_nothing(tmp_path: Path) -> None:
    from cbdsl.reporting.recorded import read_recording

    mark = tmp_path / "ran"
    pickle.loads(pickle.dumps(Harmful(mark)))
    assert mark.exists(), "the object does its harm where it is unpickled"
    mark.unlink()
    file = recording(tmp_path, {})
    np.savez(tmp_path / "episode_0.npz", time=np.array([Harmful(mark)], dtype=object))
    with pytest.raises(UsageError, match="damaged, or cut short"):
        read_recording(file)
    assert not mark.exists()


@pytest.mark.parametrize("is_absolute", [True, False])
def test_mesh_of_a_stage_by_any_path_is_read_as_a_mesh_alone(
    is_absolute: bool, tmp_path: Path
) -> None:
    secret, inner = tmp_path / "secret.obj", tmp_path / "inner"
    inner.mkdir()
    secret.write_text("password 1234\n")
    path = str(secret) if is_absolute else "../secret.obj"
    stage = (ROOT / "programs" / "stages" / "football.yaml").read_text("utf-8")
    changed = re.sub(r"(file: )\S+?([,}\s])", rf"\1{path}\2", stage, count=1)
    assert changed != stage
    (inner / "football.yaml").write_text(changed, encoding="utf-8")
    found = check_document(inner / "football.yaml", Session(Library(ROOT), {}))
    assert found and not any("1234" in diagnostic.message for diagnostic in found)


@pytest.mark.parametrize(
    "text",
    [
        "# " + "a" * composer.MOST_CHARACTERS,
        f"description: {'a' * (composer.LONGEST_TEXT + 1)}",
        f"{'a' * (composer.LONGEST_KEY + 1)}: 1",
        f"a: {[[0] * 1500] * 7}",
        f"a: {[0] * (composer.MOST_ENTRIES + 1)}",
        f"a: {'[' * (composer.DEEPEST + 1)}{']' * (composer.DEEPEST + 1)}",
    ],
    ids=["characters", "text", "key", "values", "entries", "levels"],
)
def test_document_beyond_a_bound_is_refused(text: str, tmp_path: Path) -> None:
    head = "cbdsl: 1\nkind: program\nname: a\n"
    plain = {each.code for each in findings_in(tmp_path, head)}
    beyond = {each.code for each in findings_in(tmp_path, f"{head}{text}\n")} - plain
    assert any(code.startswith("CB1") for code in beyond)


def findings_in(folder: Path, text: str) -> list[Any]:
    (folder / "a.yaml").write_text(text, encoding="utf-8")
    return check_document(folder / "a.yaml", Session(Library(folder), {}))


def test_module_of_the_live_page_writes_no_file() -> None:
    writers = {"open", "write_text", "write_bytes", "mkdir", "unlink", "rename", "replace_file"}
    for file in (ROOT / "cbdsl" / "reporting" / "live").glob("*.py"):
        calls = (
            node.func
            for node in ast.walk(ast.parse(file.read_text("utf-8")))
            if isinstance(node, ast.Call)
        )
        names = {getattr(call, "attr", getattr(call, "id", "")) for call in calls}
        assert names.isdisjoint(writers), file


def test_bounds_on_the_page_are_those_of_the_readers() -> None:
    from cbdsl.reporting import recorded
    from cbdsl.robot import robot_xml, urdf_reader
    from cbdsl.robot.meshes import mesh_damage, model_meshes, triangles
    from cbdsl_formats import budget
    from cbdsl_formats.mjcf import bounded_conversion
    from cbdsl_onnx import bounded, network

    for words in (
        f"{composer.MOST_CHARACTERS:,} characters, {composer.LONGEST_TEXT:,} in one text",
        f"{composer.LONGEST_KEY:,} in one key, {composer.MOST_NODES:,} values, "
        f"{composer.MOST_ENTRIES:,} in one list or mapping, {composer.DEEPEST} levels",
        f"{robot_xml.MOST_BYTES // 10**6} MB, {urdf_reader._MOST['link']:,} links, "
        f"{urdf_reader._DEEPEST:,} joints",
        f"{budget._MOST_STEPS // 10**6} million steps, values of {budget.MOST_PARTS:,} parts",
        f"{triangles.MOST_BYTES // 10**6} MB, {triangles.MOST:,} triangles",
        f"{mesh_damage.MOST_BYTES // 10**6} MB each, and the smallest of "
        f"{model_meshes.MOST_BYTES // 10**6} MB together",
        f"{bounded_conversion._MOST_SECONDS} s of processor time, "
        f"{bounded_conversion._MOST_BYTES // 10**9} GB",
        f"{network.NetworkDocument.most_bytes // 10**6} MB, {bounded._MOST_SECONDS} s, "
        f"{bounded._MOST_BYTES // 10**9} GB",
        f"{recorded._MOST_ARRAY_BYTES // 10**9} GB of arrays",
    ):
        assert words in page()


def test_machine_code_that_others_can_write_is_not_read(tmp_path: Path) -> None:
    from cbdsl.numeric.kernel_cache import _is_own

    file = tmp_path / "code.nbc"
    file.write_bytes(b"")
    tmp_path.chmod(0o755)
    assert _is_own(file)
    for mode in (0o666, 0o664, 0o646):
        file.chmod(mode)
        assert not _is_own(file)
    file.chmod(0o644)
    for mode in (0o777, 0o775):
        tmp_path.chmod(mode)
        assert not _is_own(file)


_SETTINGS = """
import sys
from cbdsl.cli.main import main
sys.argv[1:] = {words}
try:
    main()
except SystemExit:
    pass
from numba.core import config
config.reload_config()
print("debug is", config.DEBUG)
"""


def test_settings_of_numba_in_the_current_folder_are_not_read(tmp_path: Path) -> None:
    (tmp_path / ".numba_config.yaml").write_text("debug: 1\n")
    words = ["run", "searchtrack", "--backend", "kinematic"]
    for code in ("import numba", _SETTINGS.format(words=words)):
        done = subprocess.run(
            [sys.executable, "-c", f"{code}\nfrom numba.core import config; print(config.DEBUG)"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
        )
        expected = "1" if code == "import numba" else "0"
        assert done.stdout.splitlines()[-1] == expected, done.stderr


def test_dependencies_have_upper_bounds() -> None:
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    users = ("kinematic", "bullet", "mujoco", "learn", "editor", "gym", "trees")
    names = [*project["dependencies"]]
    for extra in users:
        names += project["optional-dependencies"][extra]
    for plugin in sorted((ROOT / "distributions").glob("*/pyproject.toml")):
        names += tomllib.loads(plugin.read_text("utf-8"))["project"]["dependencies"]
    # Distributions of this repository have its version.
    others = [name for name in names if not re.match(r"cbdsl(?![\w.])", name)]
    open_ended = [name for name in others if "<" not in name]
    assert not [name for name in open_ended if not re.search("==", name)]
