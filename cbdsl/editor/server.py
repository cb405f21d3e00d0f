"""The language server: the protocol of editors around the checker."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path

from cbdsl.editor.buffers import Buffers
from cbdsl.editor.coloring import KINDS_OF_WORDS, colored_words
from cbdsl.editor.cursor import Cursor, cursor
from cbdsl.editor.definition import definition
from cbdsl.editor.fixes import fix
from cbdsl.editor.hover import hover
from cbdsl.editor.keys import keys
from cbdsl.editor.names import choices
from cbdsl.editor.rename import Occurrence, Renaming, is_name, renaming
from cbdsl.errors.diagnostic import Diagnostic, Place, Severity
from cbdsl.errors.errors import DiagnosticsError
from cbdsl.types.registry import PluginError
from cbdsl.yaml_text.reader import formatted_text

NAME = "cbdsl"
_SEVERITIES = {
    Severity.ERROR: lsp.DiagnosticSeverity.Error,
    Severity.WARNING: lsp.DiagnosticSeverity.Warning,
    Severity.NOTE: lsp.DiagnosticSeverity.Information,
}
# Beyond this an editor shows nothing that anybody reads.
_MOST_CHOICES = 500


class Server(LanguageServer):
    """A server of one editor.

    Args:
        version: of the package.
        here: the folder in which documents are found by name until the editor names its own.
    """

    def __init__(self, version: str, here: Path) -> None:
        super().__init__(NAME, version, text_document_sync_kind=lsp.TextDocumentSyncKind.Full)
        self.buffers = Buffers(here)
        self._findings: dict[Path, list[Diagnostic]] = {}
        self.open: set[Path] = set()

    def check(self, path: Path) -> None:
        """Check an open document, and send its findings."""
        try:
            self._findings[path] = self.buffers.findings(path)
        except PluginError as error:
            message = lsp.ShowMessageParams(lsp.MessageType.Error, str(error))
            self.window_show_message(message)
            return
        lines = self.buffers.text(path).splitlines()
        shown = [_diagnostic(each, lines) for each in self._findings[path]]
        self.text_document_publish_diagnostics(
            lsp.PublishDiagnosticsParams(_uri(path), diagnostics=shown)
        )

    def changed(self, path: Path, text: str) -> None:
        """Check a document with another text."""
        self.open.add(path)
        self.buffers.change(path, text)
        self.check(path)

    def refreshed(self) -> None:
        """Check all open documents, after files on the disk changed."""
        self.buffers.forget()
        for path in sorted(self.open):
            self.check(path)

    def closed(self, path: Path) -> None:
        """Have the disk's text again, and no findings."""
        self.open.discard(path)
        self.buffers.close(path)
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(_uri(path), []))

    def cursor(self, path: Path, position: lsp.Position) -> Cursor:
        """Where a position of the editor stands in a document."""
        lines = self.buffers.text(path).splitlines()
        column = _column(self._line(path, position), position.character)
        return cursor(lines, position.line, column)

    def _line(self, path: Path, position: lsp.Position) -> str:
        """The line that a position is on; nothing beyond the end."""
        lines = self.buffers.text(path).splitlines()
        return lines[position.line] if position.line < len(lines) else ""

    def complete(self, path: Path, position: lsp.Position) -> lsp.CompletionList:
        """The names or keys that may be written at a position."""
        at, text = self.cursor(path, position), self._line(path, position)
        typed = at.word[: _column(text, position.character) - at.start]
        place = Place(str(path), position.line + 1, at.start + 1, at.end + 1)
        whole = _within(place, text)
        value, key = lsp.CompletionItemKind.Value, lsp.CompletionItemKind.Property
        offered = [(*each, value) for each in choices(self.buffers, path, at.steps)]
        if at.on_key:
            known = keys(self.buffers.text(path), at.steps)
            offered += [(name, description, key) for name, description in known.items()]
        # Editors disagree on what a word is; names have dots.
        items = [
            lsp.CompletionItem(name, detail=detail, kind=kind, text_edit=lsp.TextEdit(whole, name))
            for name, detail, kind in offered
            if typed in name
        ]
        is_all = len(items) <= _MOST_CHOICES
        return lsp.CompletionList(is_incomplete=not is_all, items=items[:_MOST_CHOICES])

    def fixes(self, path: Path, wanted: lsp.Range) -> list[lsp.CodeAction]:
        """Corrections of the findings that a range touches."""
        lines = self.buffers.text(path).splitlines()
        touched = [
            each
            for each in self._findings.get(path, ())
            if wanted.start.line <= each.place.line - 1 <= wanted.end.line
        ]
        return [action for each in touched if (action := _action(path, each, lines)) is not None]

    def rename(self, path: Path, position: lsp.Position, new: str) -> lsp.WorkspaceEdit | None:
        """The changes that give the name at a position another one.

        Raises:
            JsonRpcException: the other one is no name, or is taken; editors show why.
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
            lines = self.buffers.text(file).splitlines()
            edits = [lsp.TextEdit(_occurrence(each, lines), new) for each in spots]
            document = lsp.OptionalVersionedTextDocumentIdentifier(_uri(file))
            changes.append(lsp.TextDocumentEdit(document, list(edits)))
        if named.moved is not None:
            target = named.moved.with_stem(new)
            changes.append(lsp.RenameFile(_uri(named.moved), _uri(target), kind="rename"))
        return lsp.WorkspaceEdit(document_changes=changes)

    def renamed_range(self, path: Path, position: lsp.Position) -> lsp.Range | None:
        """The name at a position that can be renamed."""
        at = self.cursor(path, position)
        if renaming(self.buffers, path, at) is None:
            return None
        start = at.start + at.word.startswith("$")
        lines = self.buffers.text(path).splitlines()
        return _occurrence(Occurrence(position.line, start, at.end), lines)

    def colored(self, path: Path) -> lsp.SemanticTokens:
        """The words that have a kind, each relative to the one before, as the protocol wants."""
        lines, data, last = self.buffers.text(path).splitlines(), list[int](), (0, 0)
        for word in colored_words(self.buffers, path):
            where = _occurrence(Occurrence(word.line, word.start, word.end), lines)
            start = where.start.character
            step = word.line - last[0]
            column = start - last[1] if step == 0 else start
            kind = KINDS_OF_WORDS.index(word.kind)
            data += [step, column, where.end.character - start, kind, 0]
            last = word.line, start
        return lsp.SemanticTokens(data)

    def formatting(self, path: Path) -> list[lsp.TextEdit]:
        """The changes that lay a document out; none where it is no YAML."""
        text = self.buffers.text(path)
        try:
            result = formatted_text(text, str(path))
        except DiagnosticsError:
            return []
        whole = lsp.Range(lsp.Position(0, 0), lsp.Position(len(text.splitlines()) + 1, 0))
        return [] if result == text else [lsp.TextEdit(whole, result)]


def build(version: str, here: Path) -> Server:
    """A server with all that it answers."""
    server = Server(version, here)
    _follow(server)
    _answer(server)
    _change(server)
    return server


def _follow(server: Server) -> None:
    """Have it follow what is opened, typed and saved."""

    @server.feature(lsp.INITIALIZED)
    def _(params: lsp.InitializedParams) -> None:
        root = server.workspace.root_path
        if root:
            server.buffers = Buffers(Path(root))

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    def _(params: lsp.DidOpenTextDocumentParams) -> None:
        server.changed(_path(params.text_document.uri), params.text_document.text)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def _(params: lsp.DidChangeTextDocumentParams) -> None:
        uri = params.text_document.uri
        server.changed(_path(uri), server.workspace.get_text_document(uri).source)

    @server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    def _(params: lsp.DidSaveTextDocumentParams) -> None:
        server.refreshed()

    @server.feature(lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def _(params: lsp.DidChangeWatchedFilesParams) -> None:
        server.refreshed()

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def _(params: lsp.DidCloseTextDocumentParams) -> None:
        server.closed(_path(params.text_document.uri))


def _answer(server: Server) -> None:
    """Have it answer what is asked of a place."""

    @server.feature(
        lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=[".", "$", " "])
    )
    def _(params: lsp.CompletionParams) -> lsp.CompletionList:
        return server.complete(_path(params.text_document.uri), params.position)

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    def _(params: lsp.HoverParams) -> lsp.Hover | None:
        path = _path(params.text_document.uri)
        text = hover(server.buffers, path, server.cursor(path, params.position))
        kind = lsp.MarkupKind.Markdown
        return None if text is None else lsp.Hover(lsp.MarkupContent(kind, text))

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def _(params: lsp.DefinitionParams) -> lsp.Location | None:
        path = _path(params.text_document.uri)
        place = definition(server.buffers, path, server.cursor(path, params.position))
        return None if place is None else lsp.Location(_uri(place.file), _at(place.line, 0, 0))

    @server.feature(
        lsp.TEXT_DOCUMENT_CODE_ACTION,
        lsp.CodeActionOptions(code_action_kinds=[lsp.CodeActionKind.QuickFix]),
    )
    def _(params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        return server.fixes(_path(params.text_document.uri), params.range)


def _change(server: Server) -> None:
    """Have it rename, colour and format."""

    @server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
    def _(params: lsp.RenameParams) -> lsp.WorkspaceEdit | None:
        path = _path(params.text_document.uri)
        return server.rename(path, params.position, params.new_name)

    @server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
    def _(params: lsp.PrepareRenameParams) -> lsp.Range | None:
        return server.renamed_range(_path(params.text_document.uri), params.position)

    @server.feature(
        lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL,
        lsp.SemanticTokensLegend(token_types=list(KINDS_OF_WORDS), token_modifiers=[]),
    )
    def _(params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
        return server.colored(_path(params.text_document.uri))

    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    def _(params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        return server.formatting(_path(params.text_document.uri))


def _refusal(message: str) -> JsonRpcException:
    """A request that cannot be carried out, for a reason that people are told."""
    return JsonRpcException(message, lsp.LSPErrorCodes.RequestFailed.value)


def _diagnostic(finding: Diagnostic, lines: Sequence[str]) -> lsp.Diagnostic:
    nearest = finding.nearest
    hint = "" if nearest is None or nearest in finding.message else f"; did you mean '{nearest}'?"
    return lsp.Diagnostic(
        _range(finding.place, lines),
        finding.message + hint,
        severity=_SEVERITIES[finding.severity],
        code=finding.code,
        source=NAME,
        related_information=[
            lsp.DiagnosticRelatedInformation(
                lsp.Location(_uri(Path(each.place.file)), _range(each.place, ())), each.message
            )
            for each in finding.related
        ],
    )


def _action(path: Path, finding: Diagnostic, lines: Sequence[str]) -> lsp.CodeAction | None:
    correction = fix(finding, lines)
    if correction is None:
        return None
    place = Place(str(path), correction.line, correction.column, correction.end_column)
    edit = lsp.TextEdit(_range(place, lines), correction.new)
    return lsp.CodeAction(
        f"Write '{correction.new}'",
        kind=lsp.CodeActionKind.QuickFix,
        diagnostics=[_diagnostic(finding, lines)],
        edit=lsp.WorkspaceEdit(changes={_uri(path): [edit]}),
    )


def _range(place: Place, lines: Sequence[str]) -> lsp.Range:
    """A place in the editor's units, which are those of UTF-16."""
    return _within(place, lines[place.line - 1] if 0 < place.line <= len(lines) else "")


def _within(place: Place, text: str) -> lsp.Range:
    """A place on a line with some text, in code units of UTF-16."""
    ends = (_units(text, column - 1) for column in (place.column, place.end_column))
    return _at(place.line - 1, *ends)


def _occurrence(spot: Occurrence, lines: Sequence[str]) -> lsp.Range:
    """A stretch of a line in code units of UTF-16."""
    text = lines[spot.line] if spot.line < len(lines) else ""
    return _at(spot.line, _units(text, spot.start), _units(text, spot.end))


def _at(line: int, start: int, end: int) -> lsp.Range:
    return lsp.Range(lsp.Position(max(line, 0), start), lsp.Position(max(line, 0), end))


def _units(text: str, column: int) -> int:
    """A column in UTF-16 code units; beyond the end of the text each character counts once."""
    inside = text[:column]
    return max(column, 0) + sum(ord(character) > 0xFFFF for character in inside)


def _column(text: str, units: int) -> int:
    """The characters that some UTF-16 code units are."""
    encoded: Iterable[int] = (1 + (ord(character) > 0xFFFF) for character in text)
    count = 0
    for column, width in enumerate(encoded):
        if count >= units:
            return column
        count += width
    return len(text)


def _path(uri: str) -> Path:
    return Path(to_fs_path(uri) or uri)


def _uri(path: Path) -> str:
    return from_fs_path(str(path)) or path.as_uri()
