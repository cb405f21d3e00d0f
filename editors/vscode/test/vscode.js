// A stand-in for the editor: as much of its interface as the client meets on its way to a started server.
"use strict";

const path = require("node:path");
const { pathToFileURL, fileURLToPath } = require("node:url");

const nothing = { dispose() {} };
const event = () => nothing;

class Uri {
  constructor(text) {
    this.text = text;
    this.scheme = new URL(text).protocol.slice(0, -1);
    this.fsPath = this.scheme === "file" ? fileURLToPath(text) : text;
    this.path = this.fsPath;
  }
  static parse = (text) => new Uri(text);
  static file = (file) => new Uri(pathToFileURL(file).href);
  toString() {
    return this.text;
  }
}

class Emitter {
  listeners = [];
  event = (listener) => {
    this.listeners.push(listener);
    return nothing;
  };
  fire(value) {
    this.listeners.forEach((listener) => listener(value));
  }
  dispose() {}
}

class Position {
  constructor(line, character) {
    Object.assign(this, { line, character });
  }
}

class Range {
  constructor(start, end) {
    Object.assign(this, { start, end });
  }
}

class Diagnostic {
  constructor(range, message, severity) {
    Object.assign(this, { range, message, severity });
  }
}

class Plain {
  constructor(...given) {
    this.given = given;
  }
}

/** An editor with one folder and one open document. */
function editor(folder, file, text, command) {
  const said = { errors: [], findings: new Map(), features: new Set() };
  const changed = new Emitter();
  const document = {
    uri: Uri.file(path.join(folder, file)), languageId: "yaml", version: 1, fileName: file, isUntitled: false,
    isDirty: false, isClosed: false, lineCount: text.split("\n").length, getText: () => text, notebook: undefined,
  };
  const collection = {
    set: (uri, findings) => {
      said.findings.set(uri.toString(), findings);
      changed.fire(said.findings);
    },
    delete() {}, clear() {}, dispose() {}, get: () => [], has: () => false, forEach() {},
  };
  const registers = new Proxy({}, {
    get: (_, name) => (name === "createDiagnosticCollection"
      ? () => collection
      : name === "match"
        ? (selector, one) => [selector].flat().some((each) => each.language === one.languageId) ? 10 : 0
        : String(name).startsWith("onDid") ? event : (...given) => {
            said.features.add(String(name));
            return nothing;
          }),
  });
  const known = {
    version: "1.100.0", Uri, EventEmitter: Emitter, Position, Range, Diagnostic, languages: registers,
    CancellationTokenSource: class { token = { isCancellationRequested: false, onCancellationRequested: event }; cancel() {} dispose() {} },
    CancellationError: class extends Error {},
    Disposable: class { constructor(end) { this.dispose = end; } static from = () => nothing; },
    env: { language: "en", appName: "test", uriScheme: "vscode", onDidChangeTelemetryEnabled: event },
    window: {
      createOutputChannel: () => ({ append() {}, appendLine() {}, show() {}, clear() {}, dispose() {}, info() {}, error() {}, warn() {}, debug() {}, trace() {} }),
      showErrorMessage: async (message) => void said.errors.push(message),
      showInformationMessage: async () => undefined, showWarningMessage: async () => undefined,
      visibleTextEditors: [], tabGroups: { all: [], onDidChangeTabs: event, onDidChangeTabGroups: event },
      onDidChangeActiveTextEditor: event, onDidChangeVisibleTextEditors: event, onDidChangeActiveNotebookEditor: event,
      activeTextEditor: undefined, withProgress: async (_, task) => task({ report() {} }, {}),
    },
    commands: { registerCommand: () => nothing, executeCommand: async () => undefined, getCommands: async () => [] },
    workspace: new Proxy({
      workspaceFolders: [{ uri: Uri.file(folder), name: "folder", index: 0 }], textDocuments: [document], notebookDocuments: [],
      getConfiguration: () => ({ get: (name, otherwise) => (name === "command" ? command : otherwise), has: () => false, inspect: () => undefined }),
      getWorkspaceFolder: () => ({ uri: Uri.file(folder), name: "folder", index: 0 }),
      createFileSystemWatcher: () => ({ onDidCreate: event, onDidChange: event, onDidDelete: event, dispose() {} }),
      asRelativePath: (uri) => uri.fsPath, fs: {}, isTrusted: true,
    }, { get: (own, name) => own[name] ?? (/^on(Did|Will)/.test(String(name)) ? event : undefined) }),
  };
  // Whatever else it names is an enumeration or a class that it extends.
  const anything = (name) => (/(Kind|Type|Severity|Tag|Modifier|Reason|State|Location|Level|Behavior|Format)$/.test(name)
    ? new Proxy({}, { get: (_, member) => String(member) })
    : class extends Plain {});
  const vscode = new Proxy(known, {
    get: (own, name) => {
      if (typeof name === "string" && !(name in own)) own[name] = anything(name);
      return own[name];
    },
  });
  const findings = (file_) => new Promise((resolve) => {
    const uri = Uri.file(path.join(folder, file_)).toString();
    const look = () => said.findings.has(uri) && resolve(said.findings.get(uri));
    changed.event(look);
    look();
  });
  return { vscode, said, findings };
}

module.exports = { editor };
