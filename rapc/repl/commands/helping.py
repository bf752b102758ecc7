"""The commands `:help` and `:quit`."""

from __future__ import annotations

from rapc.base.names import hint
from rapc.debug.answer import Answer, command, say, table
from rapc.debug.arguments import Arguments
from rapc.errors import TextError
from rapc.repl.shell import Shell

_TYPED = (
    "(define-rap ...)   check a definition and add it to the library",
    "(location ?x ?y)   evaluate a query; *1 *2 *3 are the last answers",
    "(rap input ...)    submit a task, with options such as :priority N",
)


@command("[COMMAND]", ":help", ":help goto")
def _help(shell: Shell, args: Arguments) -> Answer:
    """List the commands, or describe a command."""
    if args:
        return _of_command(shell, args.word("command").removeprefix(":"))
    rows: list[tuple[str, str]] = []
    group = ""
    for one in shell.commands.values():
        if one.group != group:
            group = one.group
            rows.append((group.upper(), ""))
        rows.append((f":{one.name} {one.takes}".rstrip(), one.doc))
    notes = (
        "",
        *_TYPED,
        "",
        "`:help COMMAND` describes a command, with examples.",
        "Pages of the manual: tutorials/debugger, reference/repl.",
    )
    return table(("command", "description"), rows, notes=notes)


def _of_command(shell: Shell, name: str) -> Answer:
    command = shell.commands.get(name)
    if command is None:
        near = hint(name, shell.commands).replace("`", "`:", 1)
        raise TextError(f"unknown command `:{name}`{near}")
    lines = [f":{command.name} {command.takes}".rstrip(), "", command.doc]
    if command.more:
        lines.append(command.more)
    if command.examples:
        lines += ["", *(f"  {example}" for example in command.examples)]
    return say(*lines)


@command()
def _quit(shell: Shell, args: Arguments) -> Answer:
    """End the session; the run is discarded."""
    shell.left = True
    return Answer()
