"""Language server: the protocol of editors around the checker."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any, BinaryIO

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path, urlparse

from cbdsl.diagnostics.diagnostic import Diagnostic, Place, Severity
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.lines import lines_of
from cbdsl.diagnostics.published import page_of
from cbdsl.documents.ownership import is_declared, is_own
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.coloring import KINDS_OF_WORDS, colored_words
from cbdsl.editor.completions import choices, document_named, section
from cbdsl.editor.cursor import Cursor, cursor
from cbdsl.editor.fixes import fix
from cbdsl.editor.hover import hover
from cbdsl.editor.keys import keys
from cbdsl.editor.message_stream import MessageStream
from cbdsl.editor.positions import Positions
from cbdsl.editor.rename import Renaming, is_name, renaming
from cbdsl.editor.shared_names import named_at, shared_choices, shared_file
from cbdsl.yaml_text.reader import formatted_text

_SECTIONS = ("controllers", "use", "conditions")


def definition(buffers: Buffers, path: Path, cursor: Cursor) -> tuple[Path, int] | None:
    """Return the file and the line, from 0, of a controller, program, parameter or document."""
    lines = lines_of(buffers.text(path))
    if cursor.word.startswith("$"):
        declared = section(lines, "roles") | section(lines, "parameters")
        line = declared.get(cursor.word[1:])
        return None if line is None else (path, line)
    file = document_named(buffers, path, cursor.key, cursor.word)
    if file is not None and not cursor.on_key:
        return file, 0
    named = named_at(buffers, path, lines, cursor)
    if named is not None:
        return named.file, named.line
    for name in _SECTIONS:
        line = section(lines, name).get(cursor.word)
        if line is not None:
            return path, line
    shared = shared_file(buffers, path, lines, cursor.word)
    return None if shared is None else (shared, 0)


class Addresses:
    """Files that stand for the documents of an editor.

    Documents that were never saved have no file, and neither do old versions of saved documents, or
    addresses that no file can have. A path in the folder of the editor stands for such a document,
    and its references are resolved from there.

    Args:
        here: Folder of the editor.
    """

    def __init__(self, here: Path) -> None:
        self._here = here
        self._paths: dict[str, Path] = {}
        self._uris: dict[Path, str] = {}

    def path(self, uri: str) -> Path:
        """Return the file of a document; equal addresses have equal files."""
        if uri not in self._paths:
            file = to_fs_path(uri)
            is_possible = file is not None and "\0" not in file
            path = Path(file) if file and is_possible else self._stand_in(uri)
            self._paths[uri] = path
            # Editors may spell one file in several ways, as `c:` and `c%3A`. Answers use the first
            # one.
            self._uris.setdefault(path, uri)
        return self._paths[uri]

    def uri(self, path: Path) -> str:
        """Return the address of a file, as the editor wrote it, or an absolute one."""
        absolute = path.absolute()
        return self._uris.get(absolute) or from_fs_path(str(absolute)) or absolute.as_uri()

    def _stand_in(self, uri: str) -> Path:
        name = re.sub(r"[^\w.-]", "_", Path(urlparse(uri)[2]).name).strip(".") or "unsaved"
        # Two unsaved documents of one name get different files: `Untitled-1` and `1_Untitled-1`.
        names = (name if number == 0 else f"{number}_{name}" for number in count())
        paths = (self._here / each for each in names)
        return next(path for path in paths if path not in self._uris and not path.exists())


NAME = "cbdsl"
_SEVERITIES = {
    Severity.ERROR: lsp.DiagnosticSeverity.Error,
    Severity.WARNING: lsp.DiagnosticSeverity.Warning,
    Severity.NOTE: lsp.DiagnosticSeverity.Information,
}
# No reader of an editor's list looks at more choices.
_MOST_CHOICES = 500


class Server(LanguageServer):
    """Server of one editor.

    Args:
        version: Version of the package.
        here: Folder in which documents are found by name until the editor names its own.

    Attributes:
        buffers: Texts of the editor.
    """

    def __init__(self, version: str, here: Path) -> None:
        super().__init__(NAME, version, text_document_sync_kind=lsp.TextDocumentSyncKind.Full)
        self._diagnostics: dict[Path, list[Diagnostic]] = {}
        self._open: set[Path] = set()
        self.settle(here)

    def settle(self, here: Path) -> None:
        """Find documents by name in a folder."""
        self.buffers, self._addresses = Buffers(here), Addresses(here)

    def serve(self, source: BinaryIO, answers: BinaryIO) -> None:
        """Serve an editor until it ends the connection."""
        # pygls reads lines and bodies, and nothing else, of its input.
        self._messages = MessageStream(source, answers)
        self.start_io(self._messages, answers)  # type: ignore[arg-type]

    def report_server_error(self, error: Exception, source: Any) -> None:
        """Answer a message that cannot be read; pygls itself leaves the editor waiting."""
        if source is JsonRpcException:
            self._messages.refuse_body()
        else:
            super().report_server_error(error, source)

    def path(self, uri: str) -> Path:
        """Return the file that stands for a document."""
        return self._addresses.path(uri)

    def is_served(self, path: Path) -> bool:
        """Return whether a file is, or may become, a document of this project."""
        text = self.buffers.text(path)
        return not text.strip() or is_own(path, text)

    def check(self, path: Path) -> None:
        """Check an open document, and send its diagnostics; files of other tools have none."""
        # An empty list withdraws diagnostics that the editor still shows.
        self._diagnostics[path] = []
        if is_own(path, self.buffers.text(path)):
            self._diagnostics[path] = self.buffers.diagnostics(path)
        shown = self._shown(self._diagnostics[path])
        self.text_document_publish_diagnostics(
            lsp.PublishDiagnosticsParams(self._addresses.uri(path), diagnostics=shown)
        )

    def changed(self, path: Path, text: str) -> None:
        """Check a document with another text."""
        self._open.add(path)
        self.buffers.change(path, text)
        self.check(path)

    def refreshed(self) -> None:
        """Check all open documents, after files on the disk changed."""
        self.buffers.forget()
        for path in sorted(self._open):
            self.check(path)

    def closed(self, path: Path) -> None:
        """Take the disk's text again, and withdraw the diagnostics."""
        self._open.discard(path)
        self._diagnostics.pop(path, None)
        self.buffers.close(path)
        self.text_document_publish_diagnostics(
            lsp.PublishDiagnosticsParams(self._addresses.uri(path), [])
        )

    def positions(self, path: Path) -> Positions:
        """Return the conversion of positions in a file, in the units promised to the editor."""
        return Positions(self.buffers.text(path), self.workspace.position_codec)

    def cursor(self, path: Path, position: lsp.Position) -> Cursor:
        """Return the place in a document at a position of the editor."""
        line, column = self.positions(path).spot(position)
        return cursor(lines_of(self.buffers.text(path)), line, column)

    def complete(self, path: Path, position: lsp.Position) -> lsp.CompletionList:
        """Return the names or keys that may be written at a position."""
        positions = self.positions(path)
        line, column = positions.spot(position)
        at = cursor(lines_of(self.buffers.text(path)), line, column)
        typed = at.word[: column - at.start]
        whole = positions.range(line, at.start, at.end)
        value, key = lsp.CompletionItemKind.Value, lsp.CompletionItemKind.Property
        names = choices(self.buffers, path, at.steps)
        names += shared_choices(self.buffers, path, at.steps)
        offered = [(*each, value) for each in names]
        if at.on_key:
            known = keys(self.buffers.text(path), at.steps)
            offered += [(name, description, key) for name, description in known.items()]
        # Editors differ in their definition of a word; names have dots.
        items = [
            lsp.CompletionItem(name, detail=detail, kind=kind, text_edit=lsp.TextEdit(whole, name))
            for name, detail, kind in offered
            if typed in name
        ]
        # An incomplete list makes the editor request it again after the next character.
        is_all = len(items) <= _MOST_CHOICES
        return lsp.CompletionList(is_incomplete=not is_all, items=items[:_MOST_CHOICES])

    def hover(self, path: Path, position: lsp.Position) -> lsp.Hover | None:
        """Return the explanation of the name at a position."""
        text = hover(self.buffers, path, self.cursor(path, position))
        kind = lsp.MarkupKind.Markdown
        return None if text is None else lsp.Hover(lsp.MarkupContent(kind, text))

    def definition(self, path: Path, position: lsp.Position) -> lsp.Location | None:
        """Return the line where the name at a position is defined."""
        place = definition(self.buffers, path, self.cursor(path, position))
        if place is None:
            return None
        file = place[0].absolute()
        return lsp.Location(self._addresses.uri(file), self.positions(file).range(place[1], 0, 0))

    def fixes(self, path: Path, wanted: lsp.Range) -> list[lsp.CodeAction]:
        """Return the corrections of the diagnostics that a range touches."""
        positions = self.positions(path)
        first, last = (positions.spot(end)[0] for end in (wanted.start, wanted.end))
        touched = [
            each for each in self._diagnostics.get(path, ()) if first <= each.place.line - 1 <= last
        ]
        return [action for each in touched if (action := self._action(path, each)) is not None]

    def rename(self, path: Path, position: lsp.Position, new: str) -> lsp.WorkspaceEdit | None:
        """Return the changes that replace the name at a position by another one.

        Raises:
            JsonRpcException: The new name is invalid or taken; editors show the reason.
        """
        named = renaming(self.buffers, path, self.cursor(path, position))
        new = new.removeprefix("$")
        if named is None or new == named.old:
            return None
        if not is_name(new):
            raise _refusal(f"'{new}' is not a name: a letter, then letters, digits and '_'")
        if new in named.taken:
            raise _refusal(f"there is a '{new}' already")
        return self._edit(named, new)

    def _edit(self, named: Renaming, new: str) -> lsp.WorkspaceEdit:
        changes: list[lsp.TextDocumentEdit | lsp.CreateFile | lsp.RenameFile | lsp.DeleteFile] = []
        for file, spots in named.spots.items():
            positions = self.positions(file)
            edits = [lsp.TextEdit(positions.range(*each), new) for each in spots]
            document = lsp.OptionalVersionedTextDocumentIdentifier(self._addresses.uri(file))
            changes.append(lsp.TextDocumentEdit(document, list(edits)))
        if named.moved is not None:
            old, moved = named.moved, named.moved.with_stem(new)
            uri = self._addresses.uri
            changes.append(lsp.RenameFile(uri(old), uri(moved), kind="rename"))
        return lsp.WorkspaceEdit(document_changes=changes)

    def renamed_range(self, path: Path, position: lsp.Position) -> lsp.Range | None:
        """Return the range of the name at a position if it can be renamed."""
        at = self.cursor(path, position)
        if renaming(self.buffers, path, at) is None:
            return None
        positions = self.positions(path)
        start = at.start + at.word.startswith("$")
        return positions.range(positions.spot(position)[0], start, at.end)

    def colored(self, path: Path) -> lsp.SemanticTokens:
        """Return the words that have a kind, each relative to the previous one."""
        positions, data, last = self.positions(path), list[int](), lsp.Position(0, 0)
        for word in colored_words(self.buffers, path):
            where = positions.range(word.line, word.start, word.end)
            start, step = where.start.character, where.start.line - last.line
            column = start - last.character if step == 0 else start
            kind = KINDS_OF_WORDS.index(word.kind)
            data += [step, column, where.end.character - start, kind, 0]
            last = where.start
        return lsp.SemanticTokens(data)

    def formatting(self, path: Path) -> list[lsp.TextEdit]:
        """Return the changes that format a document; none if it is invalid YAML, or undeclared."""
        text = self.buffers.text(path)
        if not is_declared(text):
            return []
        try:
            result = formatted_text(text, str(path))
        except DiagnosticsError:
            return []
        return [] if result == text else [lsp.TextEdit(self.positions(path).whole(), result)]

    def _shown(self, diagnostics: Iterable[Diagnostic]) -> list[lsp.Diagnostic]:
        """Convert diagnostics, whose places may be in any files."""
        positions = cache(self.positions)

        def location(place: Place) -> lsp.Location:
            file = Path(place.file).absolute()
            return lsp.Location(self._addresses.uri(file), positions(file).of_place(place))

        return [_diagnostic(each, location) for each in diagnostics]

    def _action(self, path: Path, diagnostic: Diagnostic) -> lsp.CodeAction | None:
        correction = fix(diagnostic, lines_of(self.buffers.text(path)))
        if correction is None:
            return None
        place = Place(str(path), correction.line, correction.column, correction.end_column)
        edit = lsp.TextEdit(self.positions(path).of_place(place), correction.new)
        return lsp.CodeAction(
            f"Write '{correction.new}'",
            kind=lsp.CodeActionKind.QuickFix,
            diagnostics=self._shown([diagnostic]),
            edit=lsp.WorkspaceEdit(changes={self._addresses.uri(path): [edit]}),
        )


def build(version: str, here: Path) -> Server:
    """Return a server with all its features."""
    server = Server(version, here)
    _follow(server)
    _answer(server)
    _change(server)
    return server


def _follow(server: Server) -> None:
    """Register handlers for opened, edited and saved documents."""

    @server.feature(lsp.INITIALIZED)
    def _(params: lsp.InitializedParams) -> None:
        folders = [to_fs_path(folder) for folder in server.workspace.folders]
        for root in (server.workspace.root_path, *folders):
            if root:
                server.settle(Path(root))
                return

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    def _(params: lsp.DidOpenTextDocumentParams) -> None:
        server.changed(server.path(params.text_document.uri), params.text_document.text)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def _(params: lsp.DidChangeTextDocumentParams) -> None:
        text = server.workspace.get_text_document(params.text_document.uri).source
        server.changed(server.path(params.text_document.uri), text)

    @server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    def _(params: lsp.DidSaveTextDocumentParams) -> None:
        server.refreshed()

    @server.feature(lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def _(params: lsp.DidChangeWatchedFilesParams) -> None:
        server.refreshed()

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def _(params: lsp.DidCloseTextDocumentParams) -> None:
        server.closed(server.path(params.text_document.uri))


def _answer(server: Server) -> None:
    """Register handlers for requests about a place; files of other tools get no answers."""

    @server.feature(
        lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=[".", "$", " "])
    )
    def _(params: lsp.CompletionParams) -> lsp.CompletionList | None:
        path = server.path(params.text_document.uri)
        return server.complete(path, params.position) if server.is_served(path) else None

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    def _(params: lsp.HoverParams) -> lsp.Hover | None:
        path = server.path(params.text_document.uri)
        return server.hover(path, params.position) if server.is_served(path) else None

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def _(params: lsp.DefinitionParams) -> lsp.Location | None:
        path = server.path(params.text_document.uri)
        return server.definition(path, params.position) if server.is_served(path) else None

    @server.feature(
        lsp.TEXT_DOCUMENT_CODE_ACTION,
        lsp.CodeActionOptions(code_action_kinds=[lsp.CodeActionKind.QuickFix]),
    )
    def _(params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        return server.fixes(server.path(params.text_document.uri), params.range)


def _change(server: Server) -> None:
    """Register handlers that rename, colour and format; files of other tools stay unchanged."""

    @server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
    def _(params: lsp.RenameParams) -> lsp.WorkspaceEdit | None:
        path = server.path(params.text_document.uri)
        if not server.is_served(path):
            return None
        return server.rename(path, params.position, params.new_name)

    @server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
    def _(params: lsp.PrepareRenameParams) -> lsp.Range | None:
        path = server.path(params.text_document.uri)
        return server.renamed_range(path, params.position) if server.is_served(path) else None

    @server.feature(
        lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL,
        lsp.SemanticTokensLegend(token_types=list(KINDS_OF_WORDS), token_modifiers=[]),
    )
    def _(params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
        path = server.path(params.text_document.uri)
        return server.colored(path) if server.is_served(path) else lsp.SemanticTokens([])

    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    def _(params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        return server.formatting(server.path(params.text_document.uri))


def _refusal(message: str) -> JsonRpcException:
    """Return the answer to a request that cannot be carried out, with its reason."""
    return JsonRpcException(message, lsp.LSPErrorCodes.RequestFailed.value)


def _diagnostic(
    diagnostic: Diagnostic, location: Callable[[Place], lsp.Location]
) -> lsp.Diagnostic:
    nearest, address = diagnostic.nearest, page_of(diagnostic.code)
    hint = (
        "" if nearest is None or nearest in diagnostic.message else f"; did you mean '{nearest}'?"
    )
    return lsp.Diagnostic(
        location(diagnostic.place).range,
        diagnostic.message + hint,
        severity=_SEVERITIES[diagnostic.severity],
        code=diagnostic.code,
        code_description=lsp.CodeDescription(address) if address else None,
        source=NAME,
        related_information=[
            lsp.DiagnosticRelatedInformation(location(each.place), each.message)
            for each in diagnostic.related
        ],
    )
