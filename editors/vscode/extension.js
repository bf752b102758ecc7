// The client of `rapc lsp`: finds the server, starts it, and shows what it cannot show.
"use strict";

const fs = require("fs");
const path = require("path");
const { commands, languages, window, workspace } = require("vscode");
const { Location, Position, Range, Uri } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

/** Return the command `rapc`: of the settings, of the workspace, or on the path. */
function findServer() {
  const chosen = workspace.getConfiguration("rap").get("server");
  if (chosen) return chosen;
  const inner = process.platform === "win32" ? ["Scripts", "rapc.exe"] : ["bin", "rapc"];
  for (const folder of workspace.workspaceFolders ?? []) {
    for (const name of [".venv", "venv"]) {
      const file = path.join(folder.uri.fsPath, name, ...inner);
      if (fs.existsSync(file)) return file;
    }
  }
  const file = inner[1];
  const places = (process.env.PATH ?? "").split(path.delimiter);
  return places.map((one) => path.join(one, file)).find((one) => fs.existsSync(one));
}

async function start() {
  const command = findServer();
  if (!command) {
    const where = "in `.venv` of the workspace or on the path";
    window.showErrorMessage(`rapc was not found ${where}: pip install 'rapc[lsp]'`);
    return;
  }
  const delay = workspace.getConfiguration("rap").get("delay");
  client = new LanguageClient(
    "rapc",
    "RAP",
    { command, args: ["lsp"] },
    {
      documentSelector: [
        { scheme: "file", language: "rap" },
        { scheme: "file", pattern: "**/rapc.toml" },
      ],
      initializationOptions: { showCallers: true, delay },
    },
  );
  await client.start();
}

function toLocation({ uri, range: { start, end } }) {
  const range = new Range(start.line, start.character, end.line, end.character);
  return new Location(Uri.parse(uri), range);
}

function showCallers(uri, at, places) {
  const position = new Position(at.line, at.character);
  const found = places.map(toLocation);
  commands.executeCommand("editor.action.showReferences", Uri.parse(uri), position, found);
}

/** Lead from a handler in Python to the declaration of its primitive or datum. */
const declarations = {
  async provideDefinition({ uri }, { line, character }) {
    if (!client?.isRunning()) return [];
    const params = { textDocument: { uri: String(uri) }, position: { line, character } };
    return (await client.sendRequest("textDocument/definition", params)).map(toLocation);
  },
};

exports.activate = async (context) => {
  const python = { scheme: "file", language: "python" };
  context.subscriptions.push(
    languages.registerDefinitionProvider(python, declarations),
    commands.registerCommand("rapc.showCallers", showCallers),
    commands.registerCommand("rapc.restart", async () => {
      await client?.stop();
      await start();
    }),
  );
  await start();
};

exports.deactivate = () => client?.stop();
