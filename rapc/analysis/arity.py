"""What is said about a use with another number of arguments than was declared."""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.diagnostics import Diagnostic, Label, Rule
from rapc.base.source import Span
from rapc.base.values import format_list
from rapc.ir import nodes


def wrong_arity(
    rule: Rule,
    use: nodes.Pattern | nodes.Call | nodes.WaitFor,
    declared: tuple[str, Sequence[nodes.Argument], Span],
    *,
    most: str = "",
) -> Diagnostic:
    """The finding for a use, given the name, arguments and place declared.

    `most` goes before the number: `at most ` where fewer would do.
    """
    name, args, place = declared
    wanted = f"{len(args) or 'no'} argument{'' if len(args) == 1 else 's'}"
    return Diagnostic(
        rule=rule.name,
        message=f"`{name}` takes {most}{wanted}, not {len(use.args)}",
        span=use.span,
        labels=(Label(place, f"declared here as `{written(name, args)}`"),),
    )


def written(name: str, args: Sequence[nodes.Argument]) -> str:
    """A declared name with the names of its arguments, as a use would write it."""
    return format_list([name, *(arg.variable.name for arg in args)])
