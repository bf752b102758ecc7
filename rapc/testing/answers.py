"""What memory functions return in a test: the answers that stand in it.

A library may ask functions that nobody registered, for they come with a world that the
test does without. Which answers a test may hold at all is for the checker and for
`rapc.testing.admission`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rapc.base.values import Atom, Fact, format_list, match_pattern
from rapc.errors import Error
from rapc.ir import nodes
from rapc.testing.patterns import atom


class UnansweredQuestion(Error):
    """A question to a memory function that no answer of the test fits."""

    def __init__(self, question: Fact) -> None:
        super().__init__(f"no answer says what {format_list(question)} is")

    def __str__(self) -> str:
        """Return the message, with the clauses that asked."""
        return ", asked by ".join([self.message, *getattr(self, "__notes__", ())])


def functions(answers: Sequence[nodes.Answer]) -> Mapping[str, Callable[..., Any]]:
    """Return the functions that give `answers`, by name, as a host registers them."""
    tables: dict[str, list[tuple[Fact, Atom]]] = {}
    for answer in answers:
        name = answer.call.function
        pattern = (name, *[atom(arg) for arg in answer.call.args])
        tables.setdefault(name, []).append((pattern, answer.value.value))
    return {name: _function(name, table) for name, table in tables.items()}


def _function(name: str, table: Sequence[tuple[Fact, Atom]]) -> Callable[..., Any]:
    """Return a function that gives the first answer whose question matches."""

    def answered(memory: object, *given: Any) -> Atom:
        """Return the answer to (name given...); of a default, `given` is an index.

        Raises:
            UnansweredQuestion: if there is none.
        """
        args = given[0] if len(given) == 1 and isinstance(given[0], tuple) else given
        question = (name, *args)
        for pattern, value in table:
            if match_pattern(pattern, question) is not None:
                return value
        raise UnansweredQuestion(question)

    return answered
