"""Server of the Model Context Protocol, by the client of its own SDK and by one of another."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from tests.cli.arm_program import TEXT

mcp = pytest.importorskip("mcp", reason="the extra mcp is not installed")
ToolError = pytest.importorskip("mcp.server.mcpserver.exceptions").ToolError
make_server = pytest.importorskip("cbdsl_mcp.server").make_server
within = pytest.importorskip("cbdsl_mcp.words").within

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
        ("compare", {"first": "a,backend=ros2", "second": "b"}, "without commas"),
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
        within("document", "way_out/program.yaml", folder)


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
