"""Run random programs through both interpreters and compare the traces.

By hand: `python -m tests.reference.compare --seeds 100000`; `--seed N` shows one.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import msgspec

from rapc import events
from rapc.runtime.events.trace import record
from tests.reference.case import Case, Trace, run_rapc, run_reference
from tests.reference.generate import generate
from tests.reference.shrink import shrink
from tests.reference.vocabulary import FORMS

Row = dict[str, Any]


def written(event: events.Event) -> Row:
    """What a trace has of an event of rapc; those of the reference hold that text."""
    row: Row = msgspec.to_builtins(record(event))
    return row


def rows(trace: Trace, write: Callable[[events.Event], Row]) -> list[Row]:
    """A trace as it is compared: without serials, which say nothing of their own.

    Faults of monitors are left out: how often a monitor is tested is not laid down.
    So is what a person is told of a runaway, of tasks that are left over, of what came
    when, and of causes of failure: tests/runtime holds a table of all of them.
    """
    found = []
    for event in trace:
        row: Row = dict(event) if isinstance(event, dict) else write(event)
        del row["n"]
        row.pop("waiting", None)
        row.pop("because", None)
        results: Any = row.get("results", ())
        for result in results:
            for key in ("because", "came", "ended"):
                result.pop(key, None)
        monitor = "monitor-state at " in str(row.get("what"))
        if row["event"] != "query-faulted" or not monitor:
            found.append(row)
    return found


class Outcome(msgspec.Struct, frozen=True):
    """What came of a case: `agree`, `differ`, or who raised what; and the traces."""

    verdict: str
    rapc: list[Row]
    reference: list[Row]

    @property
    def common(self) -> int:
        """How many events the traces share from the start."""
        pairs = zip(self.rapc, self.reference, strict=False)
        return next(
            (n for n, (one, other) in enumerate(pairs) if repr(one) != repr(other)),
            min(len(self.rapc), len(self.reference)),
        )


def compare(case: Case) -> Outcome:
    """Run a case through both. What either raises is a verdict of its own."""
    traces: list[list[Row]] = []
    for name, run, write in (
        ("reference", run_reference, msgspec.to_builtins),
        ("rapc", run_rapc, written),
    ):
        try:
            traces.append(rows(run(case), write))
        except Exception as error:  # any fault of either is what is looked for
            return Outcome(f"{name} raised {type(error).__name__}: {error}", [], [])
    verdict = "agree" if repr(traces[0]) == repr(traces[1]) else "differ"
    return Outcome(verdict, traces[1], traces[0])


def report(case: Case, outcome: Outcome) -> str:
    """A mismatch as a person reads it: program, script, and where they part."""
    raps = case.text[case.text.find("(define-") :]
    lines = [f"seed {case.seed}: {outcome.verdict}", raps]
    lines += [f"row {row}" for row in case.rows] + [f"{at}" for at in case.at]
    lines += [f"fact {fact}" for fact in case.facts]
    lines += [f"agenda {case.agenda}"] if case.agenda else []
    lines += [f"task {task}" for task in case.tasks]
    lines += [f"host {entry}" for entry in case.host]
    lines += [f"solver {entry}" for entry in case.solvers]
    lines.append(f"until {case.until}, cycles {case.cycles}, {case.settings}")
    common = outcome.common
    first = max(0, common - 25)
    lines += [f"  both {short(row)}" for row in outcome.rapc[first:common]]
    lines += [f"  rapc {short(row)}" for row in outcome.rapc[common : common + 4]]
    lines += [f"  ref  {short(row)}" for row in outcome.reference[common : common + 4]]
    return "\n".join(lines)


def short(row: Row) -> str:
    """An event on one line."""
    keys = {k: v for k, v in row.items() if k not in ("event", "cycle", "time")}
    words = " ".join(f"{key}={value}" for key, value in keys.items())
    return f"c{row['cycle']} t{row['time']} {row['event']} {words}".rstrip()


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=1000)
    parser.add_argument("--from", type=int, default=0, dest="start")
    parser.add_argument("--seed", type=int)
    parser.add_argument("--stop-after", type=int, default=5)
    parser.add_argument("--forms", nargs="*", choices=FORMS, default=FORMS)
    options = parser.parse_args()
    seeds = range(options.start, options.start + options.seeds)
    if options.seed is not None:
        seeds = range(options.seed, options.seed + 1)
    kinds: Counter[str] = Counter()
    runs: Counter[str] = Counter()
    failed: list[int] = []
    tried = 0
    begun = time.monotonic()
    for seed in seeds:
        tried += 1
        case = generate(seed, options.forms)
        outcome = compare(case)
        here = Counter(kind_of(row) for row in outcome.reference)
        kinds.update(here)
        runs.update(dict.fromkeys(here, 1))
        if outcome.verdict != "agree":
            failed.append(seed)
            small = shrink(case, lambda c: compare(c).verdict)
            print(report(small, compare(small)), flush=True)
            if len(failed) >= options.stop_after:
                break
    spent = time.monotonic() - begun
    for kind, count in sorted(kinds.items()):
        print(f"{count:9} {kind} in {runs[kind]} runs")
    print(f"{len(failed)} of {tried} seeds disagree, {spent:.0f} s: {failed}")
    raise SystemExit(1 if failed else 0)


def kind_of(row: Row) -> str:
    """An event's kind, split by what distinguishes its cases."""
    for key in ("reason", "cause"):
        if key in row:
            return f"{row['event']} {row[key]}"
    return str(row["event"])


if __name__ == "__main__":
    main()
