"""Uses of names that do not meet their declaration, and names one letter apart.

The signature table (`rapc.library.signatures`) says what is wrong; here each fault gets
its place. The passes `unknown-rap`, `undeclared-predicate`, `functions`, `primitives`,
`signals` and their like choose the faults that are theirs and report them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import get_args

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.analysis.facts.index import INDEX, USES, Form, NameUse, Uses
from rapc.analysis.renaming import renaming
from rapc.base.diagnostics import Diagnostic, Label, Rule
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.library import word_span
from rapc.library.signature import Signature
from rapc.library.signatures import Fault, Use

_MOST = 60
"""How long a name may be; nobody compares longer ones by eye."""

_LOOKED_AT = 10
"""Of names that all are one letter from each other only so many are looked at."""

_TELLS_APART = re.compile(r"[0-9]+|-[a-z]$")
"""What tells names apart that come in rows: `?arm1`, `?arm-b`."""


class Close:
    """Finds names one slip away, by what is left of names that lose a letter.

    Args:
        names: the names that may be meant.
        least: how long a name must be for a slip to show.
    """

    def __init__(self, names: Iterable[str], least: int) -> None:
        self._least = least
        self._names: dict[str, list[str]] = {}
        for name in names:
            for short in self._shortened(name):
                self._names.setdefault(short, []).append(name)

    def to(self, name: str) -> str | None:
        """Return the first name close to another that is not of a row with it."""
        found = (other for other in self.all_to(name) if not is_row(name, other))
        return next(found, None)

    def all_to(self, name: str) -> Iterator[str]:
        """Yield the names one slip away from another, each once."""
        seen = {name}
        for short in self._shortened(name):
            for other in self._names.get(short, [])[:_LOOKED_AT]:
                if other not in seen and is_one_slip(name, other):
                    seen.add(other)
                    yield other

    def is_long(self, name: str) -> bool:
        """Whether a name is long enough for a slip to show, and not absurdly long."""
        return self._least <= len(name) <= _MOST

    def _shortened(self, name: str) -> Iterator[str]:
        """Yield `name`; if it is long enough, also `name` without each letter."""
        yield name
        if self.is_long(name):
            for at in range(len(name)):
                yield name[:at] + name[at + 1 :]


def is_row(one: str, other: str) -> bool:
    """Whether two names differ by what numbers or letters the names of a row."""
    return _TELLS_APART.sub("", one) == _TELLS_APART.sub("", other)


def is_one_slip(one: str, other: str) -> bool:
    """Whether one letter left out, put in, changed or swapped makes them equal."""
    start = 0
    while start < min(len(one), len(other)) and one[start] == other[start]:
        start += 1
    left, right = one[start:], other[start:]
    if len(left) == len(right):
        swapped = left[1::-1] == right[:2] and left[2:] == right[2:]
        return left[1:] == right[1:] or swapped
    longer, shorter = (left, right) if len(left) > len(right) else (right, left)
    return longer[1:] == shorter


_SHOWN = 2
"""How many places are shown besides the first one."""


class Misuse(msgspec.Struct, frozen=True):
    """A use of a name, and what is wrong with it."""

    used: NameUse
    fault: Fault


class Misuses(msgspec.Struct, frozen=True):
    """All misuses of a library."""

    found: Sequence[Misuse]
    #: Tells how often names are used: only where something is wrong is it asked.
    uses: Callable[[], Uses]


def _run(run: Pass) -> Misuses:
    faults = run.signatures.fault
    index = run.result(INDEX)
    found: list[Misuse] = []
    for used in index.uses():
        owner = used.owner
        within = ""
        if used.use == "goal" and isinstance(owner, nodes.DefineRap):
            within = owner.name
        fault = faults(used.use, used.name, used.count, used.outputs, within)
        if fault is not None:
            found.append(Misuse(used, fault))
    return Misuses(found, partial(run.result, USES))


MISUSES = Fact(_run)
"""Holds every use of a name against its declaration."""


def misuses(run: Pass, uses: Container[Use], sort: str) -> Iterator[Misuse]:
    """Yield the faults of one sort in some uses, in the order of the text by use."""
    for one in run.result(MISUSES).found:
        if one.used.use in uses and one.fault.sort == sort:
            yield one


def unknown_names(run: Pass, rule: Rule, uses: Container[Use]) -> Iterator[Diagnostic]:
    """Yield the unknown names among some uses, as findings of `rule`."""
    unknown = UnknownNames(rule)
    for one in misuses(run, uses, "unknown"):
        unknown.add(one.fault, one.used.place(run.library.files), one.used.owner)
    yield from unknown.findings(run)


def wrong_arity(run: Pass, rule: Rule, uses: Container[Use]) -> Iterator[Diagnostic]:
    """Yield the uses with another number of arguments than was declared."""
    faults: dict[tuple[str, str], list[Misuse]] = {}
    for one in misuses(run, uses, "arguments"):
        faults.setdefault((one.used.name, one.fault.message), []).append(one)
    for (name, _), wrong in faults.items():
        number = run.result(MISUSES).uses()
        every = sum(number[use, name] for use in _ALL_USES if use in uses)
        alike = every == len(wrong) >= _ALL
        for one in wrong[:1] if alike else wrong:
            declared = one.fault.declared
            assert declared is not None
            label = Label(
                declared_at(run, declared), f"declared here as `{declared.written}`"
            )
            note = f"so it is in all {every} places: is the declaration wrong?"
            yield rule.at(
                one.used.span,
                one.fault.message,
                labels=(label,),
                notes=(note,) if alike else (),
            )


_ALL = 3
"""So many uses that do not meet a declaration, and none that does, make one finding."""


def wrong_kind(run: Pass, rule: Rule, uses: Container[Use]) -> Iterator[Diagnostic]:
    """Yield the uses of names that are declared as something else."""
    files = run.library.files
    for one in misuses(run, uses, "kind"):
        declared = one.fault.declared
        assert declared is not None
        place = one.used.span if one.used.use == "computed" else one.used.place(files)
        label = Label(declared_at(run, declared), "declared here")
        yield rule.at(place, one.fault.message, labels=(label,), help=one.fault.help)


def declared_at(run: Pass, signature: Signature) -> Span:
    """Return where a name of the library is declared."""
    if signature.kind == "RAP":
        return signature.span
    return word_span(run.library.files, signature.span, 1)


class UnknownNames:
    """The uses of unknown names: one finding for each name, however often it is used.

    Args:
        rule: the rule they break.
    """

    def __init__(self, rule: Rule) -> None:
        self._rule = rule
        self._uses: dict[tuple[str, int], list[tuple[Fault, Span]]] = {}

    def add(self, fault: Fault, span: Span, owner: Form) -> None:
        """Note one more use of an unknown name, in the top-level form `owner`.

        A test is run by itself, so each has findings of its own.
        """
        test = id(owner) if type(owner) is nodes.DefineTest else 0
        self._uses.setdefault((fault.message, test), []).append((fault, span))

    def findings(self, run: Pass) -> Iterator[Diagnostic]:
        """Yield the findings, unless names may be unknown for want of a file."""
        if not run.complete:
            return
        for uses in self._uses.values():
            sure = [(fault, span) for fault, span in uses if not run.unsure(span)]
            if sure:
                fault, first = sure[0]
                here = [use for use in sure if use[1].file == first.file]
                alike = all(use.meant == fault.meant for use, _ in here)
                meant = fault.meant if alike else None
                places = [span for _, span in here]
                fix = renaming(run.library.files, fault.name, meant, places)
                spans = [span for _, span in sure]
                found = self._finding(fault, spans, _unused(run, fault.near))
                yield msgspec.structs.replace(found, fix=fix)

    def _finding(
        self, fault: Fault, spans: Sequence[Span], meant: Iterable[Label]
    ) -> Diagnostic:
        first, *further = spans
        left = len(further) - _SHOWN
        places = "one more place" if left == 1 else f"{left} more places"
        return self._rule.at(
            first,
            fault.message,
            labels=(*meant, *(Label(s, "also used here") for s in further[:_SHOWN])),
            notes=(f"it is used in {places}",) if left > 0 else (),
            help=fault.help,
        )


def _unused(run: Pass, meant: Signature | None) -> Iterator[Label]:
    """Show the declaration that may be meant, if nothing uses its name."""
    if meant is None or meant.kind not in _SAME:
        return
    uses = run.result(MISUSES).uses()
    if not any(uses[use, meant.name] for use in _SAME[meant.kind]):
        label = "nothing uses this, and the name is close"
        yield Label(declared_at(run, meant), label)


_ALL_USES: Sequence[Use] = get_args(Use)
_OF_FACTS: Sequence[Use] = ("test", "believed", "asserted", "erased", "computed")

_SAME: Mapping[str, Sequence[Use]] = {
    "RAP": ("goal",),
    "primitive": ("primitive",),
    **dict.fromkeys(("proposition", "property", "function", "query"), _OF_FACTS),
}
"""For each kind of declaration the uses of its name."""
