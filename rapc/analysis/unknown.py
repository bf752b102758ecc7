"""Names that mean nothing: one finding for each name, however often it is used."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.analyzer import Pass
from rapc.analysis.names import Names
from rapc.base.diagnostics import Diagnostic, Label, Rule
from rapc.base.source import Span

_SHOWN = 2
"""How many places are shown besides the first one."""


class Unknown:
    """Collects the uses of unknown names of one kind.

    Args:
        rule: the rule they break.
        message: the finding's sentence, with braces for the name.
        names: the names that may have been meant.
        advice: the help where no name is near, with braces for the name.
    """

    def __init__(
        self, rule: Rule, message: str, names: Names, advice: str = ""
    ) -> None:
        self._rule = rule
        self._message = message
        self._names = names
        self._advice = advice
        self._uses: dict[str, list[Span]] = {}

    def add(self, name: str, span: Span) -> None:
        """Note one more use of a name."""
        self._uses.setdefault(name, []).append(span)

    def report(self, run: Pass) -> None:
        """Report them, unless names may be unknown for want of a file."""
        if run.complete:
            for diagnostic in self._diagnostics():
                run.report(diagnostic)

    def _diagnostics(self) -> Iterator[Diagnostic]:
        for name, spans in self._uses.items():
            first, *further = spans
            left = len(further) - _SHOWN
            places = "one more place" if left == 1 else f"{left} more places"
            yield Diagnostic(
                rule=self._rule.name,
                message=self._message.format(name),
                span=first,
                labels=tuple(Label(s, "also used here") for s in further[:_SHOWN]),
                notes=(f"it is used in {places}",) if left > 0 else (),
                help=self._names.did_you_mean(name, self._advice.format(name)),
            )
