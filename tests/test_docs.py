"""Every block and every command of the docs is run, in the order of its page.

A page is a session in a folder of its own. The language of a block defines its purpose:

* ``yaml`` is a document: written to the session's folder, it has no diagnostics.
* ``python`` and ``toml`` with a file's name are files that later commands or tests use.
* ``python`` without is run, in one session a page; ``text`` behind it is its output.
* ``sh`` are ``cb`` commands, one a line.
* ``text`` is the output of the ``sh`` block before it; a line ``...`` stands for omitted lines.
  If it begins with ``cb: ``, the command is refused with this message.

Comments before a block modify its use. Every block that is not run has one.

* ``<!-- file: PATH -->``: file that the block is written to.
* ``<!-- diagnostics: CODE CODE -->``: codes of the document's diagnostics.
* ``<!-- not run: WHY -->``: the block is not executed.
* ``<!-- not compared: WHY -->``: the text varies between runs.

Commands within sentences run as well. Those with a WORD in capitals are patterns. ``cb learn`` and
``cb reproduce``, which may take hours, are only checked for their options.
"""

from __future__ import annotations

import importlib
import itertools
import re
import runpy
import shlex
import shutil
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import typer

from cbdsl.checking.document import check_document
from cbdsl.cli.main import build_app
from cbdsl.types import potential as potentials
from docs.site_hooks import on_page_markdown
from tests.cli.test_main import cb
from tests.control import test_potential_registry as test_registry
from tests.plugins.installed import refresh, write_package
from tests.test_readme import leaves, options

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "reproduction/README.md")),
    *sorted((ROOT / "distributions").glob("*/README.md")),
    *sorted(DOCS.rglob("*.md")),
]
IDS = [str(page.relative_to(ROOT)) for page in PAGES]

MARKS = ("file", "diagnostics", "not run", "not compared")
FENCE = re.compile(
    r"(?P<marks>(?:^ *<!-- .*? -->\n)*)^ *```(?P<language>\w*)\n(?P<text>.*?)^ *```$",
    re.DOTALL | re.MULTILINE,
)
#: Properties that tests/control/test_potential_registry.py checks for every potential and type.
GENERIC: list[Callable[..., None]] = [
    test_registry.test_gradient_equals_finite_differences,
    test_registry.test_small_steps_lower_phi_and_shapes_agree,
    test_registry.test_known_minimum_is_where_the_residual_leads,
    test_registry.test_compiled_potential_equals_the_interpreted_one,
    test_registry.test_rule_of_a_potential_agrees_with_its_entry,
]
#: Placeholders to fill in, or to choose from.
PATTERN = re.compile(r"[A-Z]{3,}(?!\d)|\.\.\.|[|<>]")
#: Commands that move a robot, or show how one moved.
LONG = {"run", "replay", "learn", "reproduce", "judge", "explore"}
#: Commands that take hours as the docs name them; they have tests of their own.
ENDLESS = {"learn", "lsp", "mcp", "playground", "reproduce", "judge"}
#: Options for a number of repetitions; a command with many of them is a measurement.
COUNTS = {"--episodes", "--actions", "--scenes", "--trials"}
OFTEN = 50


class Block(NamedTuple):
    """Block of a page: its language, the marks of the comments before it, and its text."""

    language: str
    marks: dict[str, str]
    text: str

    @property
    def runs(self) -> bool:
        return "not run" not in self.marks


def blocks(page: Path) -> list[Block]:
    found = []
    for match in FENCE.finditer(page.read_text("utf-8")):
        said = re.findall(r"<!-- ([\w ]+): (.*?) -->", match["marks"])
        marks = {key: value for key, value in said if key in MARKS}
        indent = len(match[0].splitlines()[-1]) - len("```")
        text = "".join(line[indent:] or "\n" for line in match["text"].splitlines(keepends=True))
        found.append(Block(match["language"], marks, text))
    return found


def in_sentences(page: Path) -> list[list[str]]:
    """Return the words of commands quoted outside of blocks; in tables, bars are escaped."""
    quoted = re.findall(r"`([^`]+)`", FENCE.sub("", page.read_text("utf-8")))
    commands = dict.fromkeys(" ".join(text.replace("\\|", "|").split()) for text in quoted)
    return [shlex.split(text)[1:] for text in commands if re.match(r"cb \w", text)]


def installed_commands() -> Any:
    """Return the command line with the plug-ins that are installed now; it takes 0.1 s to build."""
    return typer.main.get_command(build_app())


def is_concrete(words: list[str], command: Any) -> bool:
    """Return True if a command can be typed as it is, without placeholders and omissions."""
    rest = list(words)
    while rest and hasattr(command, "commands"):
        command = command.commands.get(rest.pop(0))
    if command is None or hasattr(command, "commands") or any(map(PATTERN.search, rest)):
        return False
    arguments = [each for each in command.params if each.param_type_name == "argument"]
    if any(argument.required for argument in arguments):
        return bool(rest) and not rest[0].startswith("--")
    return bool(rest) or not arguments


class Session:
    """A reader at a terminal, in the folder of one page."""

    def __init__(
        self,
        page: Path,
        folder: Path,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        self._page, self._folder = page, folder
        self._monkeypatch, self._capsys = monkeypatch, capsys
        self._printed: str | None = None  # by the last block of commands
        self._left_out = False  # whether that was not run this time
        self._names: dict[str, Any] = {}  # of the page's Python
        monkeypatch.chdir(folder)
        monkeypatch.setenv("COLUMNS", "100")

    def read(self, slow: bool) -> None:
        """Go through the page from top to bottom; all of it, or only its quick commands."""
        found = blocks(self._page)
        for place, block in enumerate(found):
            follows = found[place + 1] if place + 1 < len(found) else None
            if block.runs:
                getattr(self, f"_{block.language}")(block, slow, follows)
        installed = installed_commands()
        for words in in_sentences(self._page):
            if not is_concrete(words, installed) or words[0] in ENDLESS or measures(words):
                continue
            if slow or is_quick(words):
                assert self._type(words) == 0, words

    def _yaml(self, block: Block, slow: bool, follows: Block | None) -> None:
        file = self._file(block)
        codes = {diagnostic.code for diagnostic in check_document(file)}
        assert codes == set(block.marks.get("diagnostics", "").split()), file

    def _python(self, block: Block, slow: bool, follows: Block | None) -> None:
        if "file" in block.marks:
            compile(block.text, str(self._file(block)), "exec")
            return
        self._capsys.readouterr()
        exec(compile(block.text, str(self._page), "exec"), self._names)
        self._printed, self._left_out = self._capsys.readouterr().out, False

    def _toml(self, block: Block, slow: bool, follows: Block | None) -> None:
        install(self._file(block), self._monkeypatch)

    def _file(self, block: Block) -> Path:
        name = re.search(r"^name: (\w+)$", block.text, re.MULTILINE)
        file = self._folder / (block.marks.get("file") or (f"{name[1]}.yaml" if name else ""))
        assert file != self._folder, block.text
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(block.text, encoding="utf-8")
        return file

    def _sh(self, block: Block, slow: bool, follows: Block | None) -> None:
        lines = [shlex.split(line) for line in block.text.splitlines()]
        self._left_out = not (slow or all(is_quick(words[1:]) for words in lines))
        if self._left_out:
            return
        self._capsys.readouterr()
        shown = follows.text if follows and follows.language == "text" else ""
        refuses = shown.startswith("cb: ")
        fails = re.search(r"^\d+ errors?", shown, re.MULTILINE)
        for words in lines:
            assert words[0] == "cb", words
            assert self._type(words[1:]) == (2 if refuses else 1 if fails else 0), words
        printed = self._capsys.readouterr()
        self._printed = printed.err if refuses else printed.out

    def _text(self, block: Block, slow: bool, follows: Block | None) -> None:
        if self._left_out or "not compared" in block.marks:
            return
        assert self._printed is not None, "nothing was run that could print this"
        printed = "\n".join(line.rstrip() for line in self._printed.splitlines()) + "\n"
        for part in re.split(r"^\.\.\.\n", block.text, flags=re.MULTILINE):
            before, found, printed = printed.partition(part)
            assert found == part, before

    def _type(self, words: list[str]) -> int:
        return cb(self._monkeypatch, *words)


def measures(words: list[str]) -> bool:
    """Return True if a command repeats something so often that it takes minutes."""
    return any(
        option in COUNTS and int(value) >= OFTEN for option, value in itertools.pairwise(words)
    )


def is_quick(words: list[str]) -> bool:
    return not measures(words) and (words[0] not in LONG or "--backend" in words)


def install(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a package known as ``pip install -e .`` would."""
    said = tomllib.loads(project.read_text("utf-8"))["project"]
    write_package(project.parent, said["name"], said["entry-points"])
    monkeypatch.syspath_prepend(str(project.parent))
    refresh()


@pytest.fixture
def session(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Iterator[Session]:
    """Return the session of the page that a test is for."""
    page: Path = request.getfixturevalue("page")
    text = page.read_text("utf-8")
    if "<!-- file: " not in text:
        for folder in ("robots", "programs"):  # commands about a checkout run in one
            shutil.copytree(ROOT / folder, tmp_path / folder)
    if "kuka_iiwa" in text:
        data = Path(importlib.import_module("pybullet_data").getDataPath())
        shutil.copytree(data / "kuka_iiwa", tmp_path / "kuka_iiwa")
    yield Session(page, tmp_path, monkeypatch, capsys)
    monkeypatch.undo()  # nothing of it stays installed
    refresh()


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_blocks_and_commands_of_a_page_work(session: Session, page: Path) -> None:
    session.read(slow=False)


def is_long(page: Path, installed: Any) -> bool:
    """Return True if a page has commands that the test above leaves out."""
    typed = [shlex.split(line)[1:] for b in blocks(page) if b.language == "sh" and b.runs
             for line in b.text.splitlines()]  # fmt: skip
    told = [w for w in in_sentences(page) if is_concrete(w, installed) and not measures(w)]
    return not all(map(is_quick, [*typed, *(w for w in told if w[0] not in ENDLESS)]))


INSTALLED = installed_commands()
LONG_PAGES = [page for page in PAGES if is_long(page, INSTALLED)]


@pytest.mark.slow
@pytest.mark.parametrize("page", LONG_PAGES, ids=[page.name for page in LONG_PAGES])
def test_blocks_and_commands_of_a_page_work_on_the_simulator(session: Session, page: Path) -> None:
    session.read(slow=True)


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_every_block_of_a_page_runs_or_states_a_reason(page: Path) -> None:
    """Run each block unless it states a reason; every comment that looks like a mark is one."""
    text = page.read_text("utf-8")
    found = blocks(page)
    assert len(found) == len(re.findall(r"^ *```\w+$", text, re.MULTILINE))
    assert len(re.findall(r"^ *```$", text, re.MULTILINE)) == len(found)
    for block in found:
        assert not block.runs or hasattr(Session, f"_{block.language}"), block
        reasons = [block.marks[key] for key in ("not run", "not compared") if key in block.marks]
        assert all(len(reason.split()) > 1 for reason in reasons), block
    marks = re.findall(rf"^ *<!-- (?:{'|'.join(MARKS)}): ", text, re.MULTILINE)
    assert len(marks) == sum(len(block.marks) for block in found)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("```yaml\ncbdsl: 1\nkind: program\nname: x\n```\n", AssertionError),
        ("```yml\non: push\n```\n", AttributeError),
        ("```sh\nrm thing\n```\n", AssertionError),
        ("```sh\ncb explain CB999\n```\n", AssertionError),
        ("```sh\ncb explain CB504\n```\n```text\nCB504: fine\n```\n", AssertionError),
        ("```text\nnobody printed this\n```\n", AssertionError),
        ("<!-- file: a.py -->\n```python\nif:\n```\n", SyntaxError),
        ("```python\nprint(1)\n```\n```text\n2\n```\n", AssertionError),
        ("```python\na = 1\n```\n```python\nassert a == 2\n```\n", AssertionError),
        ("Type `cb show resources --robot nobody`.", AssertionError),
    ],
)
def test_fault_on_a_page_fails_its_test(
    text: str,
    fault: type[Exception],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    with pytest.raises(fault):
        Session(page, tmp_path, monkeypatch, capsys).read(slow=False)


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_commands_in_sentences_exist_with_their_options(page: Path) -> None:
    installed = installed_commands()
    for words in in_sentences(page):
        for leaf in leaves(installed, words):
            given = {word.split("=")[0] for word in words if word.startswith("--")}
            assert given <= options(leaf), words


def test_new_potential_of_the_page_descends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Install the page's package, and check that its potential does as the page says."""
    found = blocks(DOCS / "how_to" / "new_potential.md")
    for block in found:
        if "file" in block.marks:
            (tmp_path / block.marks["file"]).write_text(block.text, encoding="utf-8")
    install(tmp_path / "pyproject.toml", monkeypatch)
    rng = np.random.default_rng(7)
    entry = potentials.POTENTIALS["soft_spring"]
    for kind in sorted(entry.accepts):
        for test in GENERIC:
            test(entry.name, kind, None, *([rng] if "rng" in test.__annotations__ else []))
    monkeypatch.undo()
    refresh()


@pytest.mark.parametrize(
    ("page", "module"),
    [
        ("new_sensor", "wrist"),
        ("new_modifier", "orbit"),
        ("new_learner", "monte_carlo"),
        ("new_backend", "ideal"),
        ("new_command", "tally"),
        ("new_export", "table"),
        ("lerobot_robot", "follower"),
    ],
)
def test_page_shows_the_plugin_that_tests_run(page: str, module: str) -> None:
    """Compare the code except for its package: a page's modules stand alone."""
    found = blocks(DOCS / "how_to" / f"{page}.md")
    (shown,) = [each.text for each in found if each.marks.get("file") == f"{module}.py"]
    tested = ROOT / "tests" / "plugins" / "package" / "demo" / f"{module}.py"
    assert shown == tested.read_text("utf-8").replace("demo.", "")


@pytest.mark.parametrize("name", ["reference", "diagnostics"])
def test_site_build_inserts_the_same_generated_part_twice(name: str) -> None:
    text = (DOCS / f"{name}.md").read_text("utf-8")
    built = on_page_markdown(text)
    assert f"<!-- generated: {name} -->" in text.splitlines()
    assert "<!-- generated" not in built
    assert len(built.splitlines()) > 1000
    assert built == on_page_markdown(text)


def test_films_of_the_gallery_exist_and_are_small() -> None:
    text = (DOCS / "gallery.md").read_text("utf-8")
    films = re.findall(r'<video [^>]*poster="([^"]+)"\s+src="([^"]+)"', text)
    assert len(films) == text.count("\n## ")
    assert all((DOCS / each).stat().st_size < 1_000_000 for pair in films for each in pair)


def findings_of_edits() -> list[tuple[str, str, str]]:
    """Return the lines, their replacements and the findings of the page that compares notations."""
    text = (DOCS / "one_task.md").read_text("utf-8")
    row = r"^\| `([^`]+)` \| (?:`([^`]+)` )?\| ((?:CB\d+|none): .*) \|$"
    return re.findall(row, text, re.MULTILINE)


@pytest.mark.parametrize(("line", "becomes", "finding"), findings_of_edits())
def test_compared_notation_has_the_findings_of_its_page(
    line: str, becomes: str, finding: str, tmp_path: Path
) -> None:
    text = (ROOT / "programs" / "pick.yaml").read_text("utf-8")
    assert text.count(f" {line}\n") == 1
    edited = text.replace(line, becomes) if becomes else re.sub(rf" +{re.escape(line)}\n", "", text)
    file = tmp_path / "pick.yaml"
    file.write_text(edited, encoding="utf-8")
    found = [f"{each.code}: {each.message}" for each in check_document(file)]
    if finding.startswith("none"):
        assert not found
    else:
        assert any(each.startswith(finding) for each in found), found


def test_compared_notation_is_that_of_the_shipped_program() -> None:
    assert len(findings_of_edits()) == 7
    shown = next(block for block in blocks(DOCS / "one_task.md") if block.language == "yml")
    assert shown.text in (ROOT / "programs" / "pick.yaml").read_text("utf-8")


def words(text: str) -> int:
    """Return the number of words of a text, without numbers and signs."""
    return sum(bool(re.search("[A-Za-z]", word)) for word in text.split())


def test_written_pages_keep_within_their_bound_of_words() -> None:
    reports = {
        DOCS / "results.md",
        DOCS / "paper" / "paper.md",
        *(DOCS / "reproduction").glob("*.md"),
    }
    pages = {*PAGES, ROOT / "SECURITY.md"} - reports
    assert sum(words(page.read_text("utf-8")) for page in pages) <= 48300
    assert words((ROOT / "README.md").read_text("utf-8")) <= 500


def test_llms_index_names_every_page_of_the_navigation() -> None:
    """``python docs/make_llms.py`` writes it again."""
    link = re.compile(r"\]\(([\w/]+\.md)\)")
    page = runpy.run_path(str(DOCS / "make_llms.py"))["page"]
    assert link.findall((DOCS / "llms.txt").read_text("utf-8")) == link.findall(page())


def test_how_to_index_links_every_how_to_page() -> None:
    pages = {page.name for page in (DOCS / "how_to").glob("*.md")} - {"index.md"}
    linked = re.findall(r"\]\((\w+\.md)\)", (DOCS / "how_to" / "index.md").read_text("utf-8"))
    assert set(linked) == pages


def test_concepts_name_every_package() -> None:
    rows = re.findall(r"^\| (`.*?) \|", (DOCS / "concepts.md").read_text("utf-8"), re.MULTILINE)
    named = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    packages = {path.parent.name for path in (ROOT / "cbdsl").glob("*/__init__.py")}
    assert packages == named & packages and len(packages) > 20


@pytest.mark.parametrize("diagram", ["loop", "layers"])
def test_diagram_equals_the_generated_one(diagram: str) -> None:
    """``python docs/make_diagrams.py`` writes both again."""
    drawn = runpy.run_path(str(DOCS / "make_diagrams.py"))[diagram]
    assert drawn() == (DOCS / "assets" / f"{diagram}.svg").read_text("utf-8")


def test_links_within_pages_lead_to_headings() -> None:
    anchor = runpy.run_path(str(DOCS / "make_reference.py"))["anchor"]
    texts = {page: on_page_markdown(page.read_text("utf-8")) for page in PAGES}
    for page, own in texts.items():
        for target, heading in re.findall(r"\]\(([^)#:]*)#([^)]+)\)", own):
            text = texts[(page.parent / target).resolve()] if target else own
            headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
            assert heading in map(anchor, headings), f"{page.name}: {target}#{heading}"


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_links_of_a_page_lead_to_files(page: Path) -> None:
    for target in re.findall(r"\]\((?!https:)([^)#:]+)[^)]*\)", page.read_text("utf-8")):
        assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_files_of_the_project_that_are_named_exist(page: Path) -> None:
    folders = "benchmarks|cbdsl|distributions|docs|programs|reproduction|robots|schemas|tests"
    # A command with its commit names files of that commit.
    text = re.sub(r"`[^`\n]+` \([0-9a-f]{8}\)", "", FENCE.sub("", page.read_text("utf-8")))
    own = {block.marks["file"] for block in blocks(page) if "file" in block.marks}
    for name in re.findall(rf"`[^`\n]*?(?<![\w/])((?:{folders})/[\w./-]+)", text):
        assert name in own or (ROOT / name).exists(), name


def test_tests_named_by_deviations_exist() -> None:
    page = (ROOT / "docs" / "deviations.md").read_text("utf-8")
    named = set(re.findall(r"`((?:reproduction/|distributions/[\w-]+/)?tests/[\w/]+\.py)`", page))
    assert len(named) > 20
    for name in named:
        assert re.search(r"^def test_", (ROOT / name).read_text("utf-8"), re.MULTILINE), name
