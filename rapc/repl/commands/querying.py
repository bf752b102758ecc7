"""Commands that show memory: facts and solutions of queries."""

from __future__ import annotations

from rapc.debug.answer import Answer, command
from rapc.debug.arguments import Arguments
from rapc.debug.questions.state import beliefs, names_with_facts
from rapc.ir.nodes import Const, Proposition
from rapc.parser.parse import parse_formula, parse_pattern
from rapc.repl.shell import Shell


@command(
    "[NAME | QUERY]", ":memory", ":memory location", ":memory (location ?item depot)"
)
def _memory(shell: Shell, args: Arguments) -> Answer:
    """Show facts with their ages, or the solutions of a query."""
    if not args:
        return names_with_facts(shell.history)
    text = args.word("query")
    if not text.startswith("("):
        return beliefs(shell.history, text.lower())
    formula = parse_formula(text)
    known = shell.history.library.program.signatures.relations
    if isinstance(formula, Proposition) and formula.name in known:
        terms = parse_pattern(text).args
        values = [one.value if isinstance(one, Const) else None for one in terms]
        return beliefs(shell.history, formula.name, *values)
    return shell.ask(text)


@command()
def _more(shell: Shell, args: Arguments) -> Answer:
    """Show more solutions of the last query."""
    return shell.more()
