"""Which rules report, where, and how grave their findings are for one user.

A rule has a severity of its own; a user may change it, switch a rule off, or switch it
off for some files. Command line and configuration (`rapc.analysis.config`) both end
in one `Selection`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from functools import cache
from pathlib import PurePath

import msgspec

from rapc.analysis import registry
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.files import seen_from
from rapc.base.names import nearest
from rapc.errors import Error


class UnknownRuleError(Error):
    """A word that is neither a rule's name nor its code; `near` may be meant."""

    def __init__(self, word: str, near: str | None) -> None:
        meant = f"did you mean `{near}`?" if near else ""
        super().__init__(f"no rule is called `{word}`", meant)


class PerFile(msgspec.Struct, frozen=True):
    """Rules that do not report in some files."""

    #: Of file names, with `*` (folders too), `?` and `[...]`: matched against the path
    #: as seen from `root`, and against the last part of it.
    pattern: str
    #: Names of rules.
    rules: frozenset[str]
    #: The folder from which paths are seen; the working folder if empty.
    root: str = ""

    def covers(self, file: str) -> bool:
        """Whether the pattern is one of a file, by the name that spans carry."""
        path = seen_from(self.root, file)
        return any(fnmatchcase(n, self.pattern) for n in (path, PurePath(path).name))


class Selection(msgspec.Struct, frozen=True):
    """The rules that report, those that do not in some files, and severities."""

    #: The names of the rules that report.
    enabled: frozenset[str]
    #: Where some of them do not.
    per_file: tuple[PerFile, ...] = ()
    #: Severities that differ from those of the rules, by the names of rules.
    severities: Mapping[str, Severity] = {}

    def chooses(self, found: Diagnostic) -> bool:
        """Whether a finding is to be reported."""
        if found.rule not in self.enabled:
            return False
        ignoring = (one for one in self.per_file if found.rule in one.rules)
        return not any(one.covers(found.span.file) for one in ignoring)

    def graded(self, rule: Rule) -> Rule:
        """Return a rule with the severity that it has for this user."""
        wanted = self.severities.get(rule.name, rule.severity)
        if wanted is rule.severity:
            return rule
        return msgspec.structs.replace(rule, severity=wanted)


def by_default() -> frozenset[str]:
    """Return the names of the rules that report if nobody chooses: all but opt-in."""
    return frozenset(n for n, rule in registry.rules().items() if not rule.opt_in)


def errors() -> Selection:
    """Return what chooses the rules that keep a library from being run."""
    return Selection(registry.errors())


ALL = "all"
"""The word for all rules, those that are opt-in too; in capitals or not."""


def chosen_rules(words: Iterable[str]) -> frozenset[str]:
    """Return the names of rules given by name, by code, or by the word for all.

    Raises:
        UnknownRuleError: as `rule_names`.
    """
    given = list(words)
    named = rule_names(word for word in given if word.lower() != ALL)
    every = any(word.lower() == ALL for word in given)
    return frozenset(registry.rules()) if every else named


def rule_names(words: Iterable[str]) -> frozenset[str]:
    """Return the names of rules that are given by name or code.

    Raises:
        UnknownRuleError: for a word that no rule has as its name or code.
    """
    known = _words()
    chosen = set()
    for word in words:
        name = known.get(word.lower())
        if name is None:
            raise UnknownRuleError(word, nearest(word.lower(), known))
        chosen.add(name)
    return frozenset(chosen)


@cache
def _words() -> Mapping[str, str]:
    """The names of all rules, by name and by code in lower case."""
    rules = registry.rules().values()
    return {word: r.name for r in rules for word in (r.name, r.code.lower())}
