"""Which single slips in real libraries `check` finds, how near, and in how many words.

    python -m bench.mutation [KIND]... [--library PATH...]... [--each N] [--missed]
    python -m bench.mutation --harmless 200
    python -m bench.mutation --store --each 10

Each slip is made in a library in which nothing is found before; what is found then is
due to the slip. A slip that leaves the nodes of the library as they were is none, and
one that changes no trace of the library's tests, and does not keep the library from
running, is none either: found or not, it is left out, and another is made in its place.
A slip in a test always counts. `--harmless` makes changes that are no slips
(`bench.mutation_harmless`), and prints what is found all the same.
The place of a finding is where its span begins; it names the cause if it, or one of its
labels, is on a line of the slip, or if it names what the slip took away.
"""

from __future__ import annotations

import argparse
import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path

import msgspec

from bench import (
    mutation_harmless,
    mutation_more,
    mutation_plans,
    mutation_sense,
    mutation_taken,
    mutation_tests,
    mutation_whole,
    mutation_words,
)
from bench.mutation_base import Base, Edit, Kind
from bench.mutation_runs import Runs
from rapc.analysis.driver import CheckReport, check_library
from rapc.base.diagnostics import Diagnostic, Severity
from rapc.base.files import TEST_SUFFIX, lies_in
from rapc.base.source import SourceFile
from rapc.ir import nodes
from rapc.library import library
from rapc.library.loader import Loaded, Units, load, read_tests
from rapc.parser.parse import parse
from rapc.parser.unit import SourceUnit

KINDS: Mapping[str, tuple[str, Kind]] = {
    **mutation_words.KINDS,
    **mutation_sense.KINDS,
    **mutation_taken.KINDS,
    **mutation_whole.KINDS,
    **mutation_plans.KINDS,
    **mutation_more.KINDS,
    **mutation_tests.KINDS,
}
"""Every kind of slip, with the group that it is of."""

NOT_SURE: Mapping[str, str] = {
    "arguments of a step swapped": "where kinds are declared, or other uses tell",
    "arguments of a fact swapped": "where kinds are declared, or other uses tell",
    "arguments of a request swapped": "where kinds are declared, or other uses tell",
    "another constant of the library": "where it is of another kind",
    "another input as argument": "where it is of another kind",
    "`require` dropped": "where nothing else that is required brings that file in",
    "`succeed` of a loop dropped": "where the loop goes through things",
    "loop remembers nothing": "where nothing else differs from round to round",
    "looks a hundred times more seldom": "where a condition asks for a fresh belief",
    "fact of a monitor made a condition": "where that fact changes",
    "standing task with a goal": "where an agenda has it stand by",
    "constraint for a context": "where it bound a variable, or a step undoes it",
    "promise turned round": "where all that the methods do is declared",
    "conjunct dropped": "where it bound a variable; else it is a wider context",
    "conjunct negated": "where it bound a variable or contradicts something",
    "test before what it tests": "where another conjunct does not bind the variable",
    "input renamed in the index": "where kinds or other uses tell the variable",
    "`for` dropped": "where the step behind needs a value; else the order is free",
    "`until` dropped": "no: a step may as well go on",
    "window turned round": "where both times are numbers",
    "`monitor-time` from 0": "where nothing else lets the task wait",
    "monitor negated": "where contexts, goals or other RAPs say the contrary",
    "test dropped from a monitor": "where a number is left without a test",
    "monitor dropped": "where the RAP never succeeds, or has no method",
    "`(succeed nil)` dropped": "where an agenda has it stand by",
    "standing task as low as the work": "where its RAP has a monitor of its own",
    "step of priority 50": "where an agenda gives the task and one that stands by",
    "`repeat-while` dropped": "where it bound a variable or limited the rounds",
    "`succeed` negated": "where all that the methods do is declared",
    "property with two values": "but for places: things outside have two",
    "`add` for `sub`": "where no other step changes the resource",
    "change of a resource dropped": "where no other step changes the resource",
    "declared effect negated": "where a goal rests on it alone",
    "declared effect dropped": "where a goal rests on it alone",
    "`know-sensor-name` dropped": "no: the request fails when it is made",
    "comparison turned round": "where another test or a goal tells, or 0 is the least",
    "`?` before a word": "where the constant stands elsewhere, too",
    "`or` for `and`": "where it unbinds a variable, or holds always",
    "`not` forgotten": "where something contradicts what is left",
    "fresh variable for an input": "where kinds or other uses tell the input",
    "`for` another step": "where it leaves a value unbound, or makes a circle",
    "`until-start` for `until-end`": "where the other step can start at once",
    "step dropped": "where another step names it, or needs what it brings",
    "another RAP as a step": "where kinds or priorities tell",
    "another primitive": "where results, effects or kinds tell",
    "last method first": "where it asks for `otherwise`; else the order is free",
    "context dropped": "where it bound a variable, or `otherwise` stands behind it",
    "precondition is the goal": "where that says the same; an `or` may say more",
    "`succeed` asks for another fact": "where effects or kinds tell",
    "monitor asks for another fact": "where nothing changes that, or kinds tell",
    "`:background true` forgotten": "where the RAP stands by with a monitor",
    "another event awaited": "where no skill tells it, or it is awaited twice",
    "skill forgotten": "where an event that it tells is awaited",
    "wait of skills forgotten": "where no wait for success is left",
    "step given twice": "where the step is a wait or a movement that may be repeated",
    "step with the goal of the one before": "where the two goals are equal then",
    "step copied with an argument left": "where the two goals are equal then",
    "method copied with its context": "where a variable or a denied fact tells",
    "method copied with its body": "where the methods are in a row",
    "last method copied without its context": "where all values are inputs",
    "constant of a copied method changed once": "where effects or goals tell",
    "variable of a copied conjunct left": "where a variable is unbound then",
    "RAP copied with its `succeed`": "where effects or kinds tell",
    "belief of any value": "where the property may be unknown",
    "unknown value allowed": "where the property is believed",
    "fact for a belief": "no: the author may trust memory",
    "belief a hundred times as old": "no: how old is for the author",
    "sensing step dropped": "where another step needs what it brings",
    "sensing step unordered": "where another step needs what it brings",
    "monitored step as low as the others": "where the other step has steps below",
    "`until` of a monitored step dropped": "where the step only waits",
    "conjunct of a monitor dropped": "where it bound a variable",
    "monitor copied to `succeed`": "where the RAP is to stand by",
    "claim of another thing": "where the steps say what they use",
    "claim dropped": "where a method that is alike claims the thing",
    "use of a primitive dropped": "where all similar primitives use the thing",
    "promise dropped": "where a goal rests on it alone",
    "promise of another variable": "where all that the methods do is declared",
    "protection dropped": "where it ordered a value",
    "protection of another variable": "where nothing brings that fact about",
    "constraint dropped": "no: a method may as well go on",
    "deadline a hundredth as far": "where the least time is known",
    "net emptied": "where the RAP has a goal",
    "method dropped": "where another method names it",
    "step dropped with its annotations": "where another step needs what it brings",
    "goals of two steps exchanged": "where effects or variables tell",
    "order of a net dropped": "where a step needs what another brings",
    "precondition negated": "where callers or contexts say the contrary",
    "constraint negated": "where a context or a step says the contrary",
    "protection negated": "where the step brings the contrary about",
    "context negated": "where another clause says the contrary",
    "precondition dropped": "no: a RAP may as well be tried",
    "`succeed` dropped": "where a method only waits, or a counter tells stages apart",
    "result of another primitive": "where all that the steps can bring is declared",
    "general case of a memory rule first": "where the case before takes all results",
    "`until` another step": "where that step cannot end this one",
    "`until-start` for both ends": "where the two steps run at the same time",
    "standing tasks of one priority": "where one fact wakes both",
    "fact of a monitor made a context": "where that fact changes",
    "belief a hundredth as old": "where a standing task looks at times",
    "claims the other way round": "where other tasks claim the things in order",
    "another skill enabled": "where an event, a kind or a thing tells",
    "`never` of a thing that is not there": "where the constant stands nowhere else",
    "limit of a loop dropped": "where nothing else ends the loop",
    "`repeat-while` negated": "where it bound a variable, or contradicts a context",
    "change of another resource": "where the resource has another kind",
    "`repeat-while` is the goal": "where the goal holds already",
    "`repeat-while` as a precondition": "where it bound a variable",
}
"""The kinds that a check may find or not, and what that depends on."""

ROOT = Path(__file__).parent.parent
LIBRARIES: Sequence[Sequence[str]] = (
    ("stdlib/truck",),
    ("stdlib/truck-beyond",),
    ("stdlib/hallway",),
    ("examples/courier",),
    ("examples/laboratory",),
    ("examples/greenhouse.rap", "bench/greenhouse.test.rap"),
    ("bench/porter.rap", "bench/porter.test.rap"),
)
"""The libraries in which slips are made, each by its paths from the root."""


class Outcome(msgspec.Struct, frozen=True):
    """What became of one slip."""

    edit: Edit
    #: The line where the slip was made.
    row: int
    found: tuple[Diagnostic, ...]
    #: How many lines lie between the slip and the first finding.
    distance: int | None
    #: Whether the first finding, or a label of it, is on a line of the slip.
    named: bool
    #: Whether the slip keeps the library from running.
    breaks: bool = False
    #: The file with the slip.
    file: SourceFile | None = None


class Bench:
    """A library with its parsed files, of which a slip changes one.

    Args:
        paths: its files and folders; the tests in them are not part of the library.
        of_tests: make slips in the tests, and not in the library.
    """

    def __init__(self, paths: Sequence[str], of_tests: bool = False) -> None:
        self.name = paths[0]
        self._given = [ROOT / path for path in paths]
        named = [one.name for one in read_tests(map(str, self._given))]
        tests = [Path(name) for name in named if name.endswith(TEST_SUFFIX)]
        self._paths = [path for path in self._given if path not in tests]
        self._own = self._paths
        if of_tests:
            self._own = tests
            self._paths = [*self._paths, *tests]
        self._of_tests = of_tests
        self._units = Units()
        self.loaded = load(self._paths, parser=self._units)
        report = check_library(self.loaded)
        if report.findings:
            raise ValueError([f.diagnostic.message for f in report.findings])
        self.base = Base(self.loaded.library)
        self.units = {unit.file.name: unit for unit in self.loaded.units}
        self._runs: Runs | None = None
        #: How many slips no trace told, and how many of these were found.
        self.idle = self.idle_found = 0

    def edits(self, kind: str) -> list[Edit]:
        """Return the places of a kind of slip in the files of the bench."""
        group, make = KINDS[kind]
        if (group == "tests") is not self._of_tests:
            return []
        return self.own(make(self.base))

    def own(self, edits: Iterable[Edit]) -> list[Edit]:
        """Return the edits of the files of the bench, not those of required files."""
        return [
            one
            for one in edits
            if any(lies_in(one.span.file, str(path)) for path in self._own)
        ]

    def outcome(self, edit: Edit) -> Outcome | None:
        """Make a slip and check; None if the library means what it meant."""
        name, start, end = edit.span.file, edit.span.start, edit.span.end
        before = self.units[name].file.text
        file = SourceFile(name, before[:start] + edit.content + before[end:])
        unit = parse(file)
        old = self.units[name]
        same = unit.forms == old.forms and unit.tests == old.tests
        if same and not unit.diagnostics:
            return None
        report = check_library(self._with(file, unit))
        rows = range(file.row(start), file.row(start + len(edit.content)) + 1)
        judged = _judged(report, edit, rows)
        return msgspec.structs.replace(judged, file=file)

    def _with(self, file: SourceFile, unit: SourceUnit) -> Loaded:
        """Return the library with another text of a file, of which a unit is made."""
        old = self.units[file.name]
        if _requires(unit) != _requires(old):
            return load(self._paths, texts={file.name: file.text}, parser=self._units)
        units = [unit if one is old else one for one in self.loaded.units]
        linked, names = library.link(units)
        slips = [found for one in units for found in one.diagnostics]
        found = (*slips, *names)
        return Loaded(linked, tuple(units), found, self.loaded.required)

    def is_idle(self, slip: Outcome) -> bool:
        """Whether a slip leaves all traces of the tests as they were.

        Where a library has no tests nobody can tell, and the slip counts.
        """
        if slip.breaks or slip.file is None or self._of_tests:
            return False
        if self._runs is None:
            self._runs = Runs(self._given)
        owner = self.base.index.at(slip.edit.span.file, slip.edit.span.start)
        form = owner.owner if owner is not None else None
        rap = form.name if isinstance(form, nodes.DefineRap) else ""
        return self._runs.are_the_same(slip.file, rap) is True


def _requires(unit: SourceUnit) -> list[nodes.Require]:
    return [form for form in unit.forms if isinstance(form, nodes.Require)]


def _judged(report: CheckReport, edit: Edit, rows: range) -> Outcome:
    found = tuple([f.diagnostic for f in report.findings])
    breaks = report.worst() is Severity.ERROR
    if not found:
        return Outcome(edit, rows[0], (), None, False)
    places = [found[0].span, *(label.span for label in found[0].labels)]
    here = [
        report.files[span.file].row(span.start)
        for span in places
        if span.file == edit.span.file
    ]
    first = report.files[places[0].file].row(places[0].start)
    distance = min(abs(first - rows[0]), abs(first - rows[-1])) if here else 999
    about = f"`{edit.about}`"
    said = found[0].message + found[0].help
    named = any(row in rows for row in here) or about in said
    distance = 0 if first in rows else distance
    return Outcome(edit, rows[0], found, distance, named, breaks)


def outcomes(
    kind: str, benches: Sequence[Bench], each: int, seed: int
) -> Iterator[tuple[Bench, Outcome]]:
    """Yield what becomes of some slips of a kind in each library.

    Those that change nothing are left out, and others made in their place.
    """
    for bench in benches:
        places = bench.edits(kind)
        random.Random(f"{seed}:{kind}").shuffle(places)
        made = 0
        for edit in places[: each * TRIES]:
            outcome = bench.outcome(edit) if made < each else None
            if outcome is not None and bench.is_idle(outcome):
                bench.idle += 1
                bench.idle_found += bool(outcome.found)
            elif outcome is not None:
                made += 1
                yield bench, outcome


TRIES = 4
"""How many places are tried for each slip that is to count."""


def row(kind: str, made: Sequence[Outcome]) -> str:
    """Return the line of a table that tells of one kind, to the rules."""
    found = [one for one in made if one.found]
    named = sum(one.named for one in found)
    single = sum(len(one.found) == 1 for one in found)
    far = sorted(one.distance or 0 for one in found)
    middle = str(far[len(far) // 2]) if far else ""
    group = KINDS[kind][0]
    rules = sorted({one.found[0].rule for one in found})
    told = ", ".join(rules[:3])
    return (
        f"| {group} | {kind} | {len(made)} | {len(found)} | {named} | {single} "
        f"| {middle} | {told} |"
    )


STORED = Path(__file__).parents[1] / "docs" / "figures" / "slips.json"
"""The file from which `docs/generate.py` makes the table of the manual."""


def stored(benches: Sequence[Bench], each: int, seed: int) -> Mapping[str, object]:
    """Return the counts of all kinds, as `STORED` has them."""
    kinds = []
    for kind, (group, _) in KINDS.items():
        made = [one for _, one in outcomes(kind, benches, each, seed)]
        found = [one for one in made if one.found]
        far = sorted(one.distance or 0 for one in found)
        kinds.append(
            {
                "group": group,
                "slip": kind,
                "made": len(made),
                "found": len(found),
                "named": sum(one.named for one in found),
                "single": sum(len(one.found) == 1 for one in found),
                "lines": far[len(far) // 2] if far else None,
                "rules": sorted({one.found[0].rule for one in found})[:3],
                "remark": NOT_SURE.get(kind, ""),
            }
        )
    idle = sum(bench.idle for bench in benches)
    today = date.today().isoformat()
    return {"date": today, "each": each, "idle": idle, "kinds": kinds}


def main() -> None:
    """Read the command line and print tables."""
    parser = argparse.ArgumentParser(description="Which slips a check finds.")
    parser.add_argument("kind", nargs="*", help="part of the name of a kind or group")
    parser.add_argument("--library", nargs="*", action="append", help="paths of one")
    parser.add_argument("--each", type=int, default=4, help="slips of each kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--store", action="store_true", help=f"write {STORED.name}")
    parser.add_argument("--missed", action="store_true", help="print what is missed")
    parser.add_argument("--harmless", type=int, help="make so many harmless changes")
    args = parser.parse_args()
    benches = all_benches(args.library or LIBRARIES)
    if args.harmless:
        print_harmless(benches, args.harmless, args.seed)
        return
    if args.store:
        counts = msgspec.json.encode(stored(benches, args.each, args.seed))
        STORED.write_bytes(msgspec.json.format(counts, indent=1) + b"\n")
        return
    print(
        "| group | slip | made | found | cause named | one finding | lines off | by |"
    )
    print("|---|---|---:|---:|---:|---:|---:|---|")
    total: list[tuple[str, str, Outcome]] = []
    for kind, (group, _) in KINDS.items():
        if args.kind and not any(w == group or w in kind for w in args.kind):
            continue
        made = list(outcomes(kind, benches, args.each, args.seed))
        print(row(kind, [one for _, one in made]), flush=True)
        total += [(group, bench.name, one) for bench, one in made]
        for bench, one in made if args.missed else ():
            if not one.named or len(one.found) != 1:
                print(_told(bench, one))
    for title, at in (("group", 0), ("library", 1)):
        print(f"\n| {title} | slips | found | named | one finding | per cent |")
        print("|---|---:|---:|---:|---:|---:|")
        for key in dict.fromkeys(one[at] for one in total):
            print(_sum(str(key), [one[2] for one in total if one[at] == key]))
        print(_sum("all", [one[2] for one in total]))
    idle = sum(bench.idle for bench in benches)
    found = sum(bench.idle_found for bench in benches)
    print(f"\n{idle} slips more changed no trace; {found} of them were found")


def all_benches(libraries: Iterable[Sequence[str]]) -> Sequence[Bench]:
    """Return a bench for each library, and one for the tests of each."""
    every = list(libraries)
    return [
        *map(Bench, every),
        *(Bench(paths, of_tests=True) for paths in every),
    ]


def _sum(title: str, made: Sequence[Outcome]) -> str:
    found = [one for one in made if one.found]
    named = sum(one.named for one in found)
    single = sum(len(one.found) == 1 for one in found)
    share = 100 * len(found) / len(made) if made else 0
    return (
        f"| {title} | {len(made)} | {len(found)} | {named} | {single} | {share:.0f} |"
    )


def print_harmless(benches: Sequence[Bench], count: int, seed: int) -> None:
    """Make harmless changes in all libraries and print what is found."""
    places = [
        (bench, kind, edit)
        for bench in benches
        for kind, make in mutation_harmless.KINDS.items()
        for edit in bench.own(make(bench.base))
    ]
    random.Random(seed).shuffle(places)
    made = alarms = 0
    for bench, kind, edit in places:
        outcome = bench.outcome(edit) if made < count else None
        if outcome is not None:
            made += 1
            if outcome.found:
                alarms += 1
                print(f"{kind}:\n{_told(bench, outcome)}")
    print(f"{made} harmless changes, {alarms} with a finding")


def _told(bench: Bench, one: Outcome) -> str:
    span = one.edit.span
    old = bench.base.text(span).split("\n")[0]
    new = one.edit.content.split("\n")[0]
    said = [f"{found.rule}: {found.message}" for found in one.found[:3]]
    return f"    {Path(span.file).name}:{one.row}: `{old}` -> `{new}`: {said}"


if __name__ == "__main__":
    main()
