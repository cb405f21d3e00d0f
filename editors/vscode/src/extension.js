// The client of `cb lsp`: it starts the server and hands it YAML documents.
"use strict";

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

/** @type {LanguageClient | undefined} */
let client;

/** The command of the server, and the documents that are its own. */
function options() {
  const command = vscode.workspace.getConfiguration("cbdsl").get("command", "cb");
  const folder = vscode.workspace.workspaceFolders?.[0]?.uri.fsPath;
  return {
    server: { command, args: ["lsp"], options: { cwd: folder } },
    client: {
      documentSelector: [{ scheme: "file", language: "yaml" }],
      synchronize: { fileEvents: vscode.workspace.createFileSystemWatcher("**/*.{yaml,yml,urdf}") },
    },
  };
}

/** Start the server; what keeps it from starting is told with the remedy. */
async function start() {
  const { server, client: ours } = options();
  client = new LanguageClient("cbdsl", "cbdsl", server, ours);
  try {
    await client.start();
  } catch (error) {
    const remedy = "pip install 'cbdsl[editor]', or set cbdsl.command to where cb is";
    vscode.window.showErrorMessage(`cbdsl: '${server.command} lsp' does not start (${error.message}): ${remedy}`);
    client = undefined;
  }
  return client;
}

/** End the server. */
async function deactivate() {
  const running = client;
  client = undefined;
  await running?.stop();
}

async function activate(context) {
  const restart = async () => {
    await deactivate();
    await start();
  };
  context.subscriptions.push(vscode.commands.registerCommand("cbdsl.restart", restart));
  context.subscriptions.push(
    vscode.workspace.onDidChangeConfiguration((change) => {
      if (change.affectsConfiguration("cbdsl.command")) restart();
    }),
  );
  return start();
}

module.exports = { activate, deactivate };
