"""Arguments of a command: words, lists and strings, read in order."""

from __future__ import annotations

import re

from rapc.base.values import Fact, number
from rapc.debug.history import History
from rapc.errors import ArgumentError, TextError
from rapc.events import TaskCreated
from rapc.ir.nodes import Call, Const
from rapc.parser.parse import parse_fact, parse_pattern, parse_signal
from rapc.world import Time

_PART = re.compile(r'"(?:[^"\\]|\\.)*"?|[()]|;[^\n]*|[^\s()";]+|\s+')


def split(text: str) -> list[str]:
    """Return the arguments in a text: lists, strings and words.

    A list or string that is not closed extends to the end of the text.
    """
    found: list[str] = []
    depth, start = 0, 0
    for part in _PART.finditer(text):
        said = part.group()
        if depth == 0 and not said.isspace() and said[0] != ";":
            start = part.start()
        depth += (said == "(") - (said == ")")
        if depth <= 0 and not said.isspace() and said[0] != ";":
            found.append(text[start : part.end()])
            depth = 0
    if depth > 0:
        found.append(text[start:].rstrip())
    return found


def is_balanced(text: str) -> bool:
    """Return whether every list and string in a text is closed."""
    depth = 0
    for part in _PART.finditer(text):
        said = part.group()
        if said[0] == '"' and (len(said) == 1 or said[-1] != '"'):
            return False
        depth += (said == "(") - (said == ")")
    return depth <= 0


def read_pattern(text: str) -> Fact:
    """Return the pattern that a list stands for; variables are names with `?`.

    Raises:
        TextError: if the text is not a proposition or contains computed terms.
    """
    made = parse_pattern(text)
    if any(isinstance(term, Call) for term in made.args):
        raise TextError(f"a pattern may contain only values and variables: {text}")
    terms = [one.value if isinstance(one, Const) else one.name for one in made.args]  # type: ignore[union-attr]
    return (made.name, *terms)


class Arguments:
    """The arguments of a command, read from left to right.

    Args:
        text: the text after the name of the command.
    """

    def __init__(self, text: str) -> None:
        #: The text of all arguments.
        self.text = text.strip()
        self._left = split(text)

    def __bool__(self) -> bool:
        """Return whether arguments are left."""
        return bool(self._left)

    def peek(self) -> str:
        """Return the next argument without taking it; empty at the end."""
        return self._left[0] if self._left else ""

    def word(self, what: str) -> str:
        """Take the next argument.

        Raises:
            TextError: if no argument is left; `what` names the missing argument.
        """
        if not self._left:
            raise TextError(f"missing {what}")
        return self._left.pop(0)

    def rest(self) -> list[str]:
        """Take all remaining arguments."""
        found, self._left = self._left, []
        return found

    def takes(self, word: str) -> bool:
        """Take the next argument if it equals `word`; return whether it did."""
        if self.peek() == word:
            self._left.pop(0)
            return True
        return False

    def count(self, what: str, default: int | None = None) -> int:
        """Take the next argument as a whole number, with or without brackets.

        Raises:
            TextError: if the argument is not a whole number, or is missing.
        """
        if not self._left and default is not None:
            return default
        said = self.word(what).removeprefix("[").removesuffix("]")
        if not said.isdecimal():
            raise TextError(f"{what} must be a whole number, not `{said}`")
        return int(said)

    def task(self, history: History, *, ended: bool = False) -> int:
        """Take the next argument as a task: a number, or the RAP of one live task.

        Without an argument, return the task of the last cycle.

        Args:
            history: the run.
            ended: whether a RAP without live tasks stands for its last task.

        Raises:
            TextError: for an invalid argument, or if no task was selected before.
            ArgumentError: for a RAP with no live task or with several live tasks.
        """
        name = self.peek().lower()
        if name and not name.strip("[]").isdecimal():
            history.check_is_run()
            if name in history.library.program.library.raps:
                self.word("task")
                return _task_of(history, name, ended)
        number = self.count("task", history.selected or 0)
        if not number:
            raise TextError("no current task; give a task number")
        return number

    def time(self, what: str) -> Time:
        """Take the next argument as a time.

        Raises:
            TextError: if the argument is not a number.
        """
        said = self.word(what)
        try:
            return number(float(said))
        except ValueError:
            raise TextError(f"{what} must be a number, not `{said}`") from None

    def fact(self, what: str) -> Fact:
        """Take the next argument as a fact without variables.

        Raises:
            TextError: if the argument is not a fact.
        """
        return parse_fact(self.word(what))

    def signal(self) -> Fact:
        """Take the next argument as a signal with values.

        Raises:
            TextError: if the argument is not a signal.
        """
        return parse_signal(self.word("signal"))

    def end(self) -> None:
        """Validate that no argument is left.

        Raises:
            TextError: if an argument is left.
        """
        if self._left:
            raise TextError(f"unexpected argument `{self._left[0]}`")


def _task_of(history: History, rap: str, ended: bool) -> int:
    """Return the number of the live task of a RAP; with `ended`, else of its last task.

    Raises:
        ArgumentError: if the RAP has no live task or several live tasks.
    """
    goals = {n: goal for n, goal in history.run.goals().items() if goal.name == rap}
    if len(goals) == 1:
        return next(iter(goals))
    if goals:
        listed = ", ".join(f"[{number}] {goal}" for number, goal in goals.items())
        raise ArgumentError(f"`{rap}` has several live tasks: {listed}; give a number")
    last = history.last(TaskCreated, want=lambda told: told.keys["goal"].name == rap)
    if last is None:
        raise ArgumentError(f"`{rap}` has no live task")
    number: int = last.keys["task"]
    if ended:
        return number
    raise ArgumentError(f"`{rap}` has no live task; its last task was [{number}]")
