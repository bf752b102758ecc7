"""The shell: answers inputs in order, independent of a terminal.

An input that begins with a colon is a command. Any other input is RAP text. The shell
checks a definition and adds it to the library, submits a goal as a task, and evaluates
a formula over memory.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from io import StringIO
from pathlib import Path
from typing import Protocol

from rapc.base.names import did_you_mean
from rapc.base.outputs import Output, check_output
from rapc.base.resources import Value
from rapc.console.findings import concise
from rapc.debug.acts import Act, SubmitTask
from rapc.debug.answer import Answer, Command, failure, in_pairs, say, table
from rapc.debug.arguments import Arguments, is_balanced, split
from rapc.debug.breakpoints import Breakpoints
from rapc.debug.history import Branch, History
from rapc.debug.log import ToldEvent
from rapc.debug.reload import TYPED, Renewed, changed, definitions, typed_in
from rapc.errors import Error, RefusedError, TextError
from rapc.events import PrimitiveEnded, PrimitiveRequested
from rapc.host import CheckError
from rapc.language.heads import ALONE, QUERIES
from rapc.runtime.events.trace import TextTrace
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest, read_task_request
from rapc.world import innermost

_WATCHED = 3
"""The number of solutions shown for a watched query."""

MOST = 50
"""The number of solutions of a query shown at once."""


_OF_REQUESTS = (PrimitiveRequested, PrimitiveEnded)


class Actor(Protocol):
    """A run on which a user acts."""

    def act(self, act: Act) -> Answer:
        """Perform an act; return the answer. Raises Error if it is impossible."""

    def submit(self, text: str) -> Answer:
        """Submit a task. Raises Error if that is impossible."""

    def task(self, args: Arguments) -> int:
        """Take the next argument as a task. Raises Error if it is none."""


class Shell:
    """A shell that answers the inputs of a user about a run.

    Args:
        history: the history of the run.
        commands: the available commands.
        paths: the files and folders of the library.
        recording: the extent of the recording as text; empty without a recording.
    """

    def __init__(
        self,
        history: History,
        commands: Sequence[Command],
        paths: Sequence[str] = (),
        recording: str = "",
    ) -> None:
        #: The history of the run to debug, or of a playback.
        self.history = history
        self.paths = tuple(paths)
        self.recording = recording
        self.commands = {command.name: command for command in commands}
        #: The solutions of the last queries, newest first: `*1`, `*2`, `*3`.
        self.answers: list[list[dict[str, Value]]] = []
        self._names: tuple[str, ...] = ()
        self._left: list[dict[str, Value]] = []
        #: The typed texts, by the kinds and names of their definitions.
        self.typed: dict[tuple[str, str], str] = {}
        #: The events shown after a step: `all`, `requests` or `none`.
        self.shows = "all"
        #: Whether the user has left the shell.
        self.left = False
        self._breakpoints = Breakpoints(history)
        #: The texts of the queries evaluated after every stop.
        self.watches: list[str] = []
        self._seen: dict[str, str] = {}
        self._told_of = 0
        self.forget_trace()

    def refuse_output(self, path: Path, output: Output) -> None:
        """Check that a command may write a file of some kind.

        Raises:
            WriteError: as `rapc.base.outputs.check_output`, and for a file of the
                library or of the world.
        """
        run = self.history.run
        world = innermost(run.port)
        module = getattr(sys.modules.get(type(world).__module__), "__file__", None)
        read = (*self.paths, *run.library.library.files, module)
        check_output(
            path, output, (read, "is a source file of the library or of the world")
        )

    @property
    def breakpoints(self) -> Breakpoints:
        """The breakpoints of the run; raises StateError as `History.run`."""
        self.history.check_is_run()
        return self._breakpoints

    def answer(self, text: str) -> Answer:
        """Return the answer to an input."""
        text = text.strip()
        if not text or text.startswith(";"):
            return Answer()
        try:
            if text.startswith(":"):
                return self._command(text[1:])
            return self._rap_text(text)
        except (Error, ValueError) as error:
            return refusal(error)

    def _command(self, text: str) -> Answer:
        name, _, rest = text.partition(" ")
        command = self.commands.get(name)
        if command is None:
            listed = "`:help` lists all commands"
            said = did_you_mean(name, self.commands, listed, "`:{}`")
            return failure(f"unknown command `:{name}`; {said}")
        return command(self.history if command.asks else self, rest)

    # --- methods for commands --------------------------------------------------------

    def happened(self, since: int) -> list[str]:
        """Return the shown events from a serial number on, as lines of a trace."""
        if self.shows == "none":
            return []
        told = self.history.log.since(since)
        if self.shows == "requests":
            told = [one for one in told if one.kind in _OF_REQUESTS]
        return self.trace(told)

    def trace(self, told: Iterable[ToldEvent]) -> list[str]:
        """Return events as lines of a text trace."""
        for one in told:
            self._trace(one.event())
        text = self._written.getvalue()
        self._written.seek(0)
        self._written.truncate()
        return text.splitlines()

    def forget_trace(self) -> None:
        """Begin a new trace, because the time of the run has changed."""
        self._breakpoints.look_again()
        self._written = StringIO()
        self._trace = TextTrace(self._written)

    def watch(self, text: str) -> None:
        """Show the solutions of a query after every further stop.

        Raises:
            ValueError: if `text` is not a valid formula.
        """
        self.history.question(text)  # validates the names
        if text not in self.watches:
            self.watches.append(text)

    def watched(self) -> list[str]:
        """Return the lines to show after a stop: notes, logs and watches."""
        lines = [text for note in self.history.notes if (text := note())]
        lines += self._breakpoints.logged[self._told_of :]
        self._told_of = len(self._breakpoints.logged)
        for number, text in enumerate(self.watches, 1):
            said = self._watched_answers(text)
            mark = "*" if self._seen.get(text, said) != said else " "
            self._seen[text] = said
            lines.append(f"{mark} watch {number} {text}: {said}")
        return lines

    def _watched_answers(self, text: str) -> str:
        try:
            found = self.history.question(text).all()
        except ValueError as error:  # a reload has removed a declaration
            return str(error)
        said = "; ".join(in_pairs(one) or "yes" for one in found[:_WATCHED]) or "no"
        more = len(found) - _WATCHED
        return f"{said}; {more} more" if more > 0 else said

    # --- RAP text -----------------------------------------------------------------

    def _rap_text(self, text: str) -> Answer:
        if text in ("*1", "*2", "*3"):
            return self._earlier(int(text[1]))
        if not text.startswith("("):
            raise TextError(
                f"expected a command (`:help`) or a RAP form, not "
                f"`{text.split(maxsplit=1)[0]}`"
            )
        if not is_balanced(text):
            raise TextError("a parenthesis or string is not closed")
        words = text[1:].split(maxsplit=1)
        head = words[0].rstrip("()").lower() if words else ""
        if head.startswith(("define-", "declare-")):
            return self.define(text)
        return self.submit(text) if self._is_goal(head, text) else self.ask(text)

    def define(self, text: str) -> Answer:
        """Check a definition, then add it to the library or replace the old text."""
        new = definitions(text)
        kept = {named: said for named, said in self.typed.items() if named not in new}
        program = self.history.run.library
        typed = "\n\n".join((*kept.values(), text))
        answer = self.renew(typed_in(program.library, typed, program.name), TYPED)
        self.typed = {**kept, **new}
        return answer

    def renew(self, renewed: Renewed, file: str = "") -> Answer:
        """Reload the library; return the answer with the findings in `file`."""
        if not changed(
            self.history.run.library.library, renewed.library.program.library
        ):
            return say("no definition changed")
        branch = self.history.branch
        act = self.history.take_up(renewed.library)
        found = [line for line in concise(renewed.report) if line.startswith(file)]
        return say(*found, *self.branched(branch), str(act))

    def branched(self, before: Branch) -> list[str]:
        """Return a line if an act has begun a new branch, or no line."""
        now = self.history.branch
        return [] if now is before else [f"now on {now.name}; the old branch is kept"]

    def _is_goal(self, head: str, text: str) -> bool:
        """Return whether a list is a goal; with variables, a query has precedence."""
        program = self.history.library.program
        asks = head in program.signatures.predicates or head in (*ALONE, *QUERIES)
        return head in program.library.raps and not (asks and "?" in text)

    def submit(self, text: str) -> Answer:
        """Submit a task."""
        request = read_task_request(text)
        self.history.act(SubmitTask(request))
        return submitted(self.history.run, request, text)

    def act(self, act: Act) -> Answer:
        """Perform an act; the answer has what happened."""
        before, branch = self.history.serial, self.history.branch
        self.history.act(act)
        return say(*self.happened(before), *self.branched(branch), str(act))

    def task(self, args: Arguments) -> int:
        """Take the next argument as a task; default: the task of the last cycle."""
        return args.task(self.history)

    def ask(self, text: str) -> Answer:
        """Evaluate a query over memory and return the answer with its solutions."""
        forms = split(text)
        if len(forms) != 1:
            raise TextError("expected one formula")
        solutions = self.history.question(forms[0]).all()
        self.answers = [solutions, *self.answers[:2]]
        return self._solutions(solutions)

    def _earlier(self, number: int) -> Answer:
        if number > len(self.answers):
            return failure(f"no answer `*{number}`")
        return self._solutions(self.answers[number - 1])

    def _solutions(self, solutions: list[dict[str, Value]]) -> Answer:
        if not solutions:
            return say("no")
        names = list(dict.fromkeys(name for found in solutions for name in found))
        if not names:
            return say("yes")
        self._names, self._left = tuple(names), solutions
        return self.more()

    def more(self) -> Answer:
        """Return the next solutions of the last query."""
        names, solutions = self._names, self._left
        rows = [[found.get(name) for name in names] for found in solutions[:MOST]]
        self._left = solutions[MOST:]
        left = len(self._left)
        notes = [f"{left} more with `:more`"] if left else []
        return table(names, rows, none="no more solutions", notes=notes)


def submitted(run: Interpreter, request: TaskRequest, text: str) -> Answer:
    """Return the answer to a task that has been submitted to a run as text."""
    later = request.at is not None and request.at > run.now
    return say(
        f"submitted for a later time: {text}" if later else f"[{run.created}] {text}"
    )


def refusal(error: Error | ValueError) -> Answer:
    """Return the answer to an input with an error."""
    if isinstance(error, RefusedError):
        return failure(*error.reasons)
    if isinstance(error, CheckError):
        return failure(*concise(error.report))
    if isinstance(error, Error):
        return failure(error.message, *([error.help] if error.help else ()))
    return failure(str(error))  # a query with an unknown name
