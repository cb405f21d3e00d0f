"""Server with the tools; each runs a command of cb in one folder."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from mcp.server.mcpserver import Context, MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from mcp.server.mcpserver.resolve import Elicit, Resolve
from pydantic import BaseModel, Field

import cbdsl
from cbdsl_mcp.jobs import Job, Jobs
from cbdsl_mcp.words import SIMULATORS, options, plain, within

INSTRUCTIONS = """\
Programs of cbdsl are YAML documents of typed controllers. Validate a document after each change,
explain the codes of its diagnostics, and run it on a simulator. run, why, compare, learn and
explore start jobs: poll them with job, and end them with cancel. why states the first cause of an
episode that did not succeed.
"""
# Time of a command that answers at once, s.
_QUICK = 120.0

Report = dict[str, Any]
Subject = Literal[
    "types", "potentials", "learners", "knowledge", "resources", "program", "policy", "catalog"
]


class Permission(BaseModel):
    """Answer of the person at the robot."""

    may_move: bool = Field(description="The stage is set up, and the robot may move.")


class ServerScope(NamedTuple):
    """Folder of a server, and the robot whose real body may move."""

    folder: Path
    hardware: str | None


def permit(
    context: Context[ServerScope],
    program: str,
    backend: str = "kinematic",
    parameters: dict[str, str] | None = None,
) -> Permission | Elicit[Permission]:
    """Return the question to the person at a real robot; simulators need none.

    Raises:
        ToolError: The robot is not allowed.
    """
    if plain("backend", backend) in SIMULATORS:
        return Permission(may_move=False)
    folder, hardware = context.request_context.lifespan_context
    if hardware is None:
        raise ToolError(
            f"backend {backend!r} may move a real robot, and this server runs simulators only "
            f"({', '.join(SIMULATORS)}); a person starts it with --allow-hardware ROBOT"
        )
    file = folder / within("program", program, folder)
    try:
        # The command finds names from the folder, and not from where the server was started.
        word = file if file.is_file() else program
        robot = cbdsl.load(word, values=parameters or {}, folder=folder).robot.name
    except (cbdsl.DiagnosticsError, cbdsl.UsageError) as error:
        raise ToolError(f"{program}: {error}") from error
    if robot != hardware:
        raise ToolError(f"{program} is for {robot}, and --allow-hardware names '{hardware}'")
    return Elicit(f"Run {program} on the real robot {robot} by {backend}?", Permission)


def make_server(folder: Path, hardware: str | None = None) -> MCPServer:
    """Return a server for one folder.

    Args:
        folder: Folder of the documents and of all files that tools write.
        hardware: Robot whose real body may move after a person's yes; ``None`` for none.
    """
    jobs = Jobs(folder)

    @asynccontextmanager
    async def lifespan(_: MCPServer) -> AsyncIterator[ServerScope]:
        try:
            yield ServerScope(folder, hardware)
        finally:
            await jobs.close()

    server = MCPServer("cbdsl", instructions=INSTRUCTIONS, lifespan=lifespan)
    _add_documents(server, folder)
    _add_runs(server, jobs, folder)
    _add_learning(server, jobs, folder)
    _add_control(server, jobs)
    return server


def _add_documents(server: MCPServer, folder: Path) -> None:
    async def command(*words: str) -> Report:
        job = await Job.start(words, folder)
        await job.wait(_QUICK)
        await job.cancel()
        return job.report

    @server.tool(name="list")
    async def list_(kind: str = "programs") -> Report:
        """List the documents of a kind: programs, robots, stages, schemas or policies."""
        return await command("list", plain("kind", kind), "--json")

    @server.tool()
    async def show(what: Subject, name: str = "") -> Report:
        """Show types, potentials, learners or knowledge; or, by name, resources of a robot, etc."""
        if not name:
            return await command("show", what)
        word = within("name", name, folder)
        return await command("show", what, f"--robot={word}" if what == "resources" else word)

    @server.tool()
    async def validate(document: str) -> Report:
        """Check a document; diagnostics have a code, a place and a remedy."""
        return await command("validate", within("document", document, folder), "--format=json")

    @server.tool()
    async def explain(code: str) -> Report:
        """Explain the code of a diagnostic, such as CB504, with a wrong and a correct example."""
        return await command("explain", plain("code", code))

    @server.tool()
    async def fix(document: str) -> Report:
        """Correct the diagnostics of a document that have one sure correction."""
        file = folder / within("document", document, folder)
        if not file.is_file():
            raise ToolError(f"document: {document!r} is no file in {folder}")
        return await command("validate", "--fix", document)


async def _started(jobs: Jobs, *words: str) -> Report:
    number = await jobs.start(words)
    await jobs.job(number).wait(1.0)
    return {"job": number, **jobs.job(number).report}


def _add_runs(server: MCPServer, jobs: Jobs, folder: Path) -> None:
    @server.tool()
    async def run(
        permission: Annotated[Permission, Resolve(permit)],
        program: str,
        stage: str | None = None,
        seed: int = 0,
        episodes: int = 1,
        backend: str = "kinematic",
        parameters: dict[str, str] | None = None,
        record: str | None = None,
    ) -> Report:
        """Run episodes of a program as a job; each prints a JSON object with its ending."""
        given: dict[str, object] = {"stage": _file(stage, folder), "seed": seed}
        given |= {"episodes": episodes, "backend": plain("backend", backend)}
        given |= {"with": parameters, "record": _file(record, folder), "json": True}
        if backend not in SIMULATORS:
            if not permission.may_move:
                raise ToolError(f"the person did not allow {program} on a real robot")
            given["yes"] = True
        return await _started(jobs, "run", within("program", program, folder), *options(given))

    @server.tool()
    async def why(
        what: str, stage: str | None = None, seed: int = 0, episodes: int = 1,
        backend: str = "kinematic", try_changes: bool = False,
    ) -> Report:  # fmt: skip
        """Explain episodes of a program or a recording that did not succeed, as a job."""
        given: dict[str, object] = {"seed": seed, "episodes": episodes, "json": True}
        given |= {"backend": _simulator(backend), "stage": _file(stage, folder), "try": try_changes}
        return await _started(jobs, "why", within("what", what, folder), *options(given))

    @server.tool()
    async def compare(
        first: str, second: str, seeds: str = "0-19", backend: str = "kinematic"
    ) -> Report:
        """Compare the success rates of two programs on the same seeds, as a job."""
        sides = [within("program", each, folder) for each in (first, second)]
        if any(sign in each for each in sides for sign in ",@"):
            raise ToolError("programs of a comparison are names or files without , and @")
        words = [f"{each},backend={_simulator(backend)}" for each in sides]
        return await _started(
            jobs, "compare", *words, *options({"seeds": plain("seeds", seeds), "json": True})
        )


def _add_learning(server: MCPServer, jobs: Jobs, folder: Path) -> None:
    @server.tool()
    async def learn(
        program: str, out: str, stage: str | None = None, episodes: int = 10, seed: int = 0,
        backend: str = "kinematic",
    ) -> Report:  # fmt: skip
        """Learn a policy of a program as a job, and write it to the file `out`, NAME.yaml."""
        given: dict[str, object] = {"out": _file(out, folder), "stage": _file(stage, folder)}
        given |= {"episodes": episodes, "seed": seed, "backend": _simulator(backend)}
        return await _started(jobs, "learn", within("program", program, folder), *options(given))

    @server.tool()
    async def explore(
        programs: list[str], stage: str, feature: str, out: str, actions: int = 100, seed: int = 0,
        backend: str = "kinematic",
    ) -> Report:  # fmt: skip
        """Explore the affordances of an object by programs, as a job that writes a catalog."""
        given: dict[str, object] = {"stage": _file(stage, folder), "out": _file(out, folder)}
        given |= {"feature": plain("feature", feature), "actions": actions, "seed": seed}
        given |= {"backend": _simulator(backend), "json": True}
        names = [within("program", each, folder) for each in programs]
        return await _started(jobs, "explore", *names, *options(given))


def _add_control(server: MCPServer, jobs: Jobs) -> None:
    @server.tool()
    async def job(number: int, wait: float = 10.0) -> Report:
        """Return the state and the output of a job, after at most `wait` seconds if it runs."""
        chosen = jobs.job(number)
        await chosen.wait(min(max(wait, 0.0), 60.0))
        return {"job": number, **chosen.report}

    @server.tool()
    async def cancel(number: int) -> Report:
        """Cancel a job; its finished episodes and recordings stay."""
        await jobs.job(number).cancel()
        return {"job": number, **jobs.job(number).report}


def _file(value: str | None, folder: Path) -> str | None:
    return None if value is None else within("file", value, folder)


def _simulator(backend: str) -> str:
    if backend not in SIMULATORS:
        raise ToolError(f"backend {backend!r} is no simulator (known: {', '.join(SIMULATORS)})")
    return backend
