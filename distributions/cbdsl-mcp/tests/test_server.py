"""Server of the Model Context Protocol, by the client of its own SDK and by one of another."""

from __future__ import annotations

import asyncio
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from tests.cli.arm_program import TEXT
from tests.conftest import ROOT

mcp = pytest.importorskip("mcp", reason="the extra mcp is not installed")
ToolError = pytest.importorskip("mcp.server.mcpserver.exceptions").ToolError
Jobs = pytest.importorskip("cbdsl_mcp.jobs").Jobs
make_server = pytest.importorskip("cbdsl_mcp.server").make_server
words = pytest.importorskip("cbdsl_mcp.words")

TOOLS = {
    "list", "show", "validate", "explain", "fix", "run", "why", "compare", "learn", "explore",
    "job", "cancel",
}  # fmt: skip
#: Folder with node_modules/@modelcontextprotocol/sdk.
NODE_SDK = os.environ.get("CB_MCP_NODE_SDK", "")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "raise_arm.yaml").write_text(TEXT, "utf-8")
    return tmp_path


def served(
    folder: Path,
    do: Callable[[Any], Awaitable[None]],
    *,
    hardware: str | None = None,
    answer: Any = None,
) -> None:
    """Call tools of a server in this process."""

    async def run() -> None:
        asked = {} if answer is None else {"elicitation_callback": answer}
        async with mcp.Client(make_server(folder, hardware), **asked) as client:
            await do(client)

    asyncio.run(run())


async def call(client: Any, tool: str, **given: Any) -> dict[str, Any]:
    """Return the report of a tool."""
    result = await client.call_tool(tool, given)
    assert not result.is_error, result.content
    report: dict[str, Any] = json.loads(result.content[0].text)
    return report


async def refused(client: Any, tool: str, **given: Any) -> str:
    """Return the message of a tool that refuses its arguments."""
    result = await client.call_tool(tool, given)
    assert result.is_error
    return str(result.content[0].text)


def test_server_has_a_tool_for_each_command(folder: Path) -> None:
    async def do(client: Any) -> None:
        tools = (await client.list_tools()).tools
        assert {each.name for each in tools} == TOOLS
        assert all(each.description for each in tools)

    served(folder, do)


def test_server_checks_explains_and_corrects_a_document(folder: Path) -> None:
    file = folder / "raise_arm.yaml"
    file.write_text(TEXT.replace("effector: arm}", "efector: arm}", 1), "utf-8")

    async def do(client: Any) -> None:
        report = await call(client, "validate", document="raise_arm.yaml")
        assert report["exit_code"] == 1
        (diagnostic, *_) = json.loads(report["output"])["findings"]
        assert "efector" in json.dumps(diagnostic)
        meaning = await call(client, "explain", code=diagnostic["code"])
        assert diagnostic["code"] in meaning["output"]
        assert (await call(client, "fix", document="raise_arm.yaml"))["exit_code"] == 0
        assert file.read_text("utf-8") == TEXT

    served(folder, do)


def test_server_lists_and_shows_whole_documents(folder: Path) -> None:
    async def do(client: Any) -> None:
        listed = await call(client, "list", kind="programs")
        assert len(json.loads(listed["output"])) > 30
        for what, name, part in (
            ("program", "raise_arm.yaml", "condition ◁ reach"),
            ("resources", "sixaxis", "arm.position"),
            ("knowledge", "", ""),
        ):
            shown = await call(client, "show", what=what, name=name)
            assert shown["exit_code"] == 0, shown
            assert part in shown["output"]

    served(folder, do)


def test_report_of_a_long_output_has_its_end(folder: Path) -> None:
    async def do(client: Any) -> None:
        report = await call(client, "show", what="program", name="fetch")
        assert report["dropped_bytes"] > 0
        assert len(report["output"].encode()) + report["dropped_bytes"] > 100_000
        assert not report["output"].startswith("fetch")

    served(folder, do)


def test_server_explains_and_compares_episodes(folder: Path) -> None:
    async def ended(client: Any, tool: str, **given: Any) -> Any:
        started = await call(client, tool, **given)
        report = await call(client, "job", number=started["job"], wait=60)
        assert report["exit_code"] == 0, report
        return json.loads(report["output"].splitlines()[-1])

    async def do(client: Any) -> None:
        far = await ended(client, "why", what="reach", stage="out_of_reach", seed=1)
        assert (far["seed"], far["cause"]["kind"]) == (1, "out_of_reach")
        near = await ended(client, "why", what="raise_arm.yaml")
        assert (near["seed"], near["failed"]) == (0, False)
        names = {"first": "raise_arm.yaml", "second": "raise_arm.yaml"}
        rates = await ended(client, "compare", seeds="0-1", **names)
        assert rates["successes"] == [1, 1]

    served(folder, do)


def test_server_imports_nothing_from_its_folder(folder: Path) -> None:
    (folder / "typer.py").write_text("raise SystemExit('imported')", "utf-8")

    async def do(client: Any) -> None:
        report = await call(client, "validate", document="raise_arm.yaml")
        assert report["exit_code"] == 0, report

    served(folder, do)


def test_options_of_zero_are_given() -> None:
    given = {"seed": 0, "with": {"arm": "left"}, "json": True, "try": False, "record": None}
    assert list(words.options(given)) == ["--seed=0", "--with=arm=left", "--json"]


def test_server_runs_a_job_and_cancels_another(folder: Path) -> None:
    async def do(client: Any) -> None:
        started = await call(client, "run", program="raise_arm.yaml", seed=3)
        report = await call(client, "job", number=started["job"], wait=60)
        assert report["state"] == "done"
        assert json.loads(report["output"].splitlines()[-1])["succeeded"]
        long = await call(client, "run", program="raise_arm.yaml", episodes=100_000)
        assert long["state"] == "running"
        ended = await call(client, "cancel", number=long["job"])
        assert (ended["state"], ended["exit_code"]) == ("cancelled", 130)

    served(folder, do)


@pytest.mark.parametrize(
    ("tool", "given", "message"),
    [
        ("validate", {"document": "../other.yaml"}, "is outside of"),
        ("validate", {"document": "/etc/passwd"}, "is outside of"),
        ("validate", {"document": "--help"}, "neither a name nor a file"),
        ("run", {"program": "raise_arm.yaml", "record": "../out"}, "is outside of"),
        ("run", {"program": "raise_arm.yaml", "backend": "ros2"}, "runs simulators only"),
        ("run", {"program": "raise_arm.yaml", "backend": "--yes"}, "neither a name nor a file"),
        ("why", {"what": "raise_arm.yaml", "backend": "ros2"}, "is no simulator"),
        ("compare", {"first": "a,backend=ros2", "second": "b"}, "without , and @"),
        ("compare", {"first": "a", "second": "b@HEAD~1"}, "without , and @"),
        ("job", {"number": 7}, "no job 7"),
    ],
)
def test_server_refuses_arguments_beyond_its_folder_and_simulators(
    folder: Path, tool: str, given: dict[str, Any], message: str
) -> None:
    async def do(client: Any) -> None:
        assert message in await refused(client, tool, **given)

    served(folder, do)


def test_folder_is_not_left_by_a_link(
    folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    (folder / "way_out").symlink_to(tmp_path_factory.mktemp("elsewhere"))
    with pytest.raises(ToolError, match="is outside of"):
        words.within("document", "way_out/program.yaml", folder)


@pytest.mark.parametrize(
    ("hardware", "content", "message"),
    [
        ("panda", {"may_move": True}, "--allow-hardware names 'panda'"),
        ("sixaxis", {"may_move": False}, "did not allow raise_arm.yaml on a real robot"),
        ("sixaxis", None, ""),
    ],
)
def test_real_robot_does_not_move_without_a_person(
    folder: Path, hardware: str, content: dict[str, bool] | None, message: str
) -> None:
    questions: list[str] = []

    async def answer(_: Any, asked: Any) -> Any:
        questions.append(asked.message)
        action = "decline" if content is None else "accept"
        return mcp.types.ElicitResult(action=action, content=content)

    async def do(client: Any) -> None:
        given = {"program": "raise_arm.yaml", "backend": "ros2"}
        assert message in await refused(client, "run", **given)
        assert len(questions) == (hardware == "sixaxis")

    served(folder, do, hardware=hardware, answer=answer)


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """Return the programs that the server would start, which all end immediately."""
    begin, started = asyncio.create_subprocess_exec, list[tuple[str, ...]]()

    async def note(*words: str, **given: Any) -> Any:
        started.append(words)
        return await begin(sys.executable, "-c", "", **given)

    monkeypatch.setattr(asyncio, "create_subprocess_exec", note)
    return started


def test_tools_run_commands_of_cb_alone(folder: Path, commands: list[tuple[str, ...]]) -> None:
    file = "raise_arm.yaml"
    calls: dict[str, dict[str, Any]] = {
        "list": {}, "show": {"what": "types"}, "validate": {"document": file},
        "run": {"program": file},
        "explain": {"code": "CB504"}, "fix": {"document": file}, "why": {"what": file},
        "compare": {"first": file, "second": file}, "learn": {"program": file, "out": "o.yaml"},
        "explore": {"programs": [file], "stage": "s", "feature": "red", "out": "o.yaml"},
    }  # fmt: skip

    async def do(client: Any) -> None:
        for tool, given in calls.items():
            await call(client, tool, **given)

    served(folder, do)
    assert calls.keys() == TOOLS - {"job", "cancel"}
    assert {words[:4] for words in commands} == {
        (sys.executable, "-P", "-c", "from cbdsl.cli.main import main; main()")
    }
    assert [words[4] for words in commands] == [
        "validate" if tool == "fix" else tool for tool in calls
    ]


def test_yes_of_a_client_starts_the_run(folder: Path, commands: list[tuple[str, ...]]) -> None:
    async def answer(*_: Any) -> Any:
        return mcp.types.ElicitResult(action="accept", content={"may_move": True})

    async def do(client: Any) -> None:
        await call(client, "run", program="raise_arm.yaml", backend="ros2")

    served(folder, do, hardware="sixaxis", answer=answer)
    assert "--yes" in commands[0]


def test_program_that_changes_robots_during_the_question_is_refused(
    folder: Path, commands: list[tuple[str, ...]]
) -> None:
    async def answer(*_: Any) -> Any:
        shutil.copy(ROOT / "programs" / "searchtrack.yaml", folder / "raise_arm.yaml")
        return mcp.types.ElicitResult(action="accept", content={"may_move": True})

    async def do(client: Any) -> None:
        message = await refused(client, "run", program="raise_arm.yaml", backend="ros2")
        assert "raise_arm.yaml is for dexter" in message

    served(folder, do, hardware="sixaxis", answer=answer)
    assert not commands


def test_client_that_cannot_ask_a_person_is_refused(
    folder: Path, commands: list[tuple[str, ...]]
) -> None:
    async def do(client: Any) -> None:
        given = {"program": "raise_arm.yaml", "backend": "ros2"}
        with pytest.raises(mcp.MCPError, match="licitation"):
            await client.call_tool("run", given)

    served(folder, do, hardware="sixaxis")
    assert not commands


def test_server_bounds_the_number_of_jobs(folder: Path) -> None:
    async def do() -> None:
        jobs = Jobs(folder, most=1)
        await jobs.start(("list",))
        with pytest.raises(ToolError, match="1 jobs run already"):
            await jobs.start(("list",))
        await jobs.close()
        assert jobs.job(1).report["state"] == "cancelled"

    asyncio.run(do())


def test_page_names_all_tools() -> None:
    page = (ROOT / "docs" / "how_to" / "serve_a_client_of_mcp.md").read_text("utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    assert set(re.findall(r"`(\w+)`", "".join(rows))) == TOOLS


def test_robot_of_a_name_is_that_of_the_folder(folder: Path) -> None:
    (folder / "searchtrack.yaml").write_text(TEXT.replace("raise_arm", "searchtrack"), "utf-8")

    async def do(client: Any) -> None:
        message = await refused(client, "run", program="searchtrack", backend="ros2")
        assert "searchtrack is for sixaxis" in message

    served(folder, do, hardware="dexter")


CLIENT = """
import { Client } from "@modelcontextprotocol/sdk/client/index.js";
import { StdioClientTransport } from "@modelcontextprotocol/sdk/client/stdio.js";
const [python, folder] = process.argv.slice(2);
const args = ["-c", "from cbdsl.cli.main import main; main()", "mcp", "--folder", folder];
const client = new Client({ name: "test", version: "1" });
await client.connect(new StdioClientTransport({ command: python, args }));
const call = async (name, given) => {
  const result = await client.callTool({ name, arguments: given });
  if (result.isError) throw new Error(result.content[0].text);
  return JSON.parse(result.content[0].text);
};
const tools = (await client.listTools()).tools.map((each) => each.name);
const checked = await call("validate", { document: "raise_arm.yaml" });
const started = await call("run", { program: "raise_arm.yaml", seed: 3 });
const ended = await call("job", { number: started.job, wait: 60 });
const refused = await client.callTool({ name: "validate", arguments: { document: "../x" } });
console.log(JSON.stringify({ tools, checked, ended, refused: refused.isError }));
await client.close();
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@pytest.mark.skipif(not NODE_SDK, reason="CB_MCP_NODE_SDK names no folder with the npm package")
def test_client_of_another_sdk_runs_a_program(folder: Path) -> None:
    script = Path(NODE_SDK) / "cbdsl_client.mjs"
    script.write_text(CLIENT, "utf-8")
    try:
        run = subprocess.run(
            ["node", str(script), sys.executable, str(folder)],
            capture_output=True, text=True, timeout=200, check=False,
        )  # fmt: skip
    finally:
        script.unlink()
    assert run.returncode == 0, run.stderr
    said = json.loads(run.stdout)
    assert set(said["tools"]) == TOOLS
    assert said["checked"]["exit_code"] == 0
    assert json.loads(said["ended"]["output"].splitlines()[-1])["succeeded"]
    assert said["refused"] is True
