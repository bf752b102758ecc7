"""The selection: the rules that report, the files, and the severities of findings.

A rule has a default severity. A user may change the severity, disable a rule, or
disable a rule for some files. The command line and the configuration
(`rapc.analysis.config`) are both converted to one `Selection`.
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
    """An unknown rule name or code; `near` is a similar name."""

    def __init__(self, word: str, near: str | None) -> None:
        meant = f"did you mean `{near}`?" if near else ""
        super().__init__(f"unknown rule `{word}`", meant)


class PerFile(msgspec.Struct, frozen=True):
    """Rules that do not report in some files."""

    #: Pattern of file names, with `*` (folders too), `?` and `[...]`: matched against
    #: the path relative to `root`, and against the last part of the path.
    pattern: str
    #: Names of rules.
    rules: frozenset[str]
    #: The folder that paths are relative to; empty for the working directory.
    root: str = ""

    def covers(self, file: str) -> bool:
        """Return whether the pattern matches a file, by the file name in spans."""
        path = seen_from(self.root, file)
        return any(fnmatchcase(n, self.pattern) for n in (path, PurePath(path).name))


class Selection(msgspec.Struct, frozen=True):
    """The enabled rules, the exceptions for files, and the severities."""

    #: The names of the rules that report.
    enabled: frozenset[str]
    #: The rules that do not report in some files.
    per_file: tuple[PerFile, ...] = ()
    #: Severities that differ from the default, by the names of rules.
    severities: Mapping[str, Severity] = {}

    def chooses(self, found: Diagnostic) -> bool:
        """Return whether to report a finding."""
        if found.rule not in self.enabled:
            return False
        ignoring = (one for one in self.per_file if found.rule in one.rules)
        return not any(one.covers(found.span.file) for one in ignoring)

    def graded(self, rule: Rule) -> Rule:
        """Return a rule with the severity that the user has chosen."""
        wanted = self.severities.get(rule.name, rule.severity)
        if wanted is rule.severity:
            return rule
        return msgspec.structs.replace(rule, severity=wanted)


def by_default() -> frozenset[str]:
    """Return the names of the rules enabled by default: all but opt-in rules."""
    return frozenset(n for n, rule in registry.rules().items() if not rule.opt_in)


def errors() -> Selection:
    """Return the selection of the rules that prevent a library from running."""
    return Selection(registry.errors())


ALL = "all"
"""The word for all rules, including opt-in rules; upper or lower case."""


def chosen_rules(words: Iterable[str]) -> frozenset[str]:
    """Return the names of rules given by name, by code, or by the word for all.

    Raises:
        UnknownRuleError: if a word is not a rule.
    """
    given = list(words)
    named = rule_names(word for word in given if word.lower() != ALL)
    every = any(word.lower() == ALL for word in given)
    return frozenset(registry.rules()) if every else named


def rule_names(words: Iterable[str]) -> frozenset[str]:
    """Return the names of rules given by name or code.

    Raises:
        UnknownRuleError: if a word is neither the name nor the code of a rule.
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
    """Return the names of all rules, by name and by code in lower case."""
    rules = registry.rules().values()
    return {word: r.name for r in rules for word in (r.name, r.code.lower())}
