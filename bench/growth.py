"""How checking grows with a text: constructs at n, 2n and 4n, and their times.

    python -m bench.growth [NAME]...

Four times the text should take four times as long, or little more; 16 is quadratic.
The times are CPU seconds of `check_library` and of reading before it, and, for texts
that can be laid out, those of `rapc fmt` in rows of their own.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Mapping

from bench.common import short
from rapc.analysis.driver import check_library
from rapc.base.source import SourceFile
from rapc.library.loader import load_text
from rapc.parser.formatter import formatted

STEPS = (1, 2, 4)

LIMIT = 8
"""So many times as long for four times the text is too much."""


def _raps(n: int) -> str:
    return "".join(f"(define-rap (r{i}) (succeed t))\n" for i in range(n))


def _methods_tried(n: int) -> str:
    asked = "".join(f"(method (context (method-tried m{i})))\n" for i in range(n))
    return f"(define-rap (a) (succeed nil)\n{asked})"


def _comments_that_suppress(n: int) -> str:
    return "; rapc: ignore[unknown-rap]\n" * n + _raps(1)


def _suppressions(n: int) -> str:
    return "".join(
        f"; rapc: ignore[unknown-rap]\n(define-rap (a{i}) (method (task-net "
        f"(t (gone-{i})))))\n"
        for i in range(n)
    )


def _file_suppressions(n: int) -> str:
    return "; rapc: file-ignore[unknown-rap]\n" * n + "".join(
        f"(define-rap (a{i}) (method (task-net (t (gone-{i})))))\n" for i in range(n)
    )


def _suppressed_steps(n: int) -> str:
    steps = "".join(
        f"; rapc: ignore[unknown-rap]\n(t{i} (gone-{i}))\n" for i in range(n)
    )
    return f"(define-rap (a) (method (task-net\n{steps})))"


def _unknown(n: int) -> str:
    return "".join(f"(define-rap (r{i}) (succeed (gone-{i})))\n" for i in range(n))


def _chain(n: int) -> str:
    steps = " ".join(f"(t{i} (r) (for t{i + 1}))" for i in range(n))
    net = f"(task-net {steps} (t{n} (r)))"
    declared = (
        "(declare-primitive go () (okay))(define-rap (r) (method (primitive (go))))"
    )
    return f"{declared}(define-rap (a) (method {net}))"


def _calls(n: int) -> str:
    return "".join(
        f"(define-rap (r{i}) (method (task-net (t (r{(i + 1) % n})))))\n"
        for i in range(n)
    )


def _methods(n: int) -> str:
    return f"(define-rap (a) {' '.join(f'(method m{i} (task-net))' for i in range(n))})"


def _terms(n: int) -> str:
    return (
        "(declare-memory-proposition p (?x))\n(define-rap (a) (method (notations "
        + "(p 1)" * n
        + ") (task-net)))"
    )


def _open(n: int) -> str:
    return "(define-rap (a) (succeed t)\n" * n


_FACTS = """\
(declare-memory-property p (?a ?v) unknown)
(declare-memory-proposition q (?a))
(declare-primitive act (?a) (okay) :on (okay (q ?a)))
"""


def _constants(n: int) -> str:
    return _FACTS + "".join(
        f"(define-rap (r{i}) (succeed (p c{i:05} w)) (method (primitive (act box))))\n"
        for i in range(n)
    )


def _contexts(n: int) -> str:
    asked = " ".join(f"(p ?x{i} {i}) (not (q ?x{i}))" for i in range(20))
    return _FACTS + "".join(
        f"(define-rap (r{i}) (method (context (and {asked})) (primitive (act a))))\n"
        for i in range(n)
    )


def _tasks(n: int) -> str:
    tasks = " ".join(
        f"(task (r) :priority {i % 9} :background {'true' if i % 2 else 'false'})"
        for i in range(n)
    )
    rap = "(define-rap (r) (succeed nil) (monitor-state (q a)) (method (primitive "
    return f"{_FACTS}{rap}(act a))))\n(define-agenda d {tasks})"


def _dense_calls(n: int) -> str:
    return "".join(
        f"(define-rap (r{i}) (method (task-net "
        + " ".join(f"(t{j} (r{(i * 7 + j * 13) % n}))" for j in range(8))
        + ")))\n"
        for i in range(n)
    )


def _literals(n: int) -> str:
    asked = " ".join(f"(q ?x{i})" for i in range(n))
    return f"{_FACTS}(define-rap (r) (succeed (and {asked})))\n"


def _monitors(n: int) -> str:
    return _FACTS + "".join(
        f"(define-rap (r{i}) (succeed nil) (monitor-state (and (q ?x) (p ?x {i})))"
        f" (method (primitive (act a{i}))))\n"
        for i in range(n)
    )


def _queries(n: int) -> str:
    return _FACTS + "".join(
        f"(define-query (a{i} ?x) (and (q ?x) (a{i + 1} ?x)))\n" for i in range(n)
    )


def _rows(n: int) -> str:
    rows = " ".join(f"((act a{i}) okay :asserts ((q a{i})))" for i in range(n))
    rap = "(define-rap (r) (method (primitive (act a0))))"
    return f"{_FACTS}{rap}\n(define-test t (script {rows}) (task (r)))"


def _protected(n: int) -> str:
    steps = " ".join(f"(t{i} (r) ((q a{i}) for t{i + 1}))" for i in range(n))
    rap = "(define-rap (r) (effects (not (q a1))) (method (primitive (act a))))\n"
    return f"{_FACTS}{rap}(define-rap (s) (method (task-net {steps} (t{n} (r)))))"


def _claims(n: int) -> str:
    raps = "".join(
        f"(define-rap (r{i}) (method (claims (arm {i}) (leg {n - i}))"
        f" (task-net (t (r{i // 2})))))\n"
        for i in range(n)
    )
    tasks = " ".join(f"(task (r{i}) :priority {i % 7})" for i in range(n))
    return f"{_FACTS}{raps}(define-agenda day {tasks})"


CONSTRUCTS: Mapping[str, tuple[Callable[[int], str], int]] = {
    "RAPs": (_raps, 2000),
    "`method-tried` of unknown methods": (_methods_tried, 500),
    "comments that suppress, in a row": (_comments_that_suppress, 2000),
    "RAPs with a suppression each": (_suppressions, 1000),
    "`file-ignore`, once for each RAP": (_file_suppressions, 1000),
    "suppressed steps of one form": (_suppressed_steps, 500),
    "unknown predicates": (_unknown, 1000),
    "steps in a chain": (_chain, 500),
    "RAPs that call in a circle": (_calls, 1000),
    "methods of one RAP": (_methods, 1000),
    "notations of one method": (_terms, 2000),
    "forms that are never closed": (_open, 500),
    "constants that stand once": (_constants, 500),
    "contexts of forty parts": (_contexts, 50),
    "tasks of one agenda": (_tasks, 500),
    "RAPs that call eight others": (_dense_calls, 1000),
    "facts of one conjunction": (_literals, 500),
    "RAPs with a monitor": (_monitors, 500),
    "queries that ask each other in a row": (_queries, 500),
    "rows of one script": (_rows, 500),
    "steps that protect facts": (_protected, 200),
    "RAPs that claim two things": (_claims, 200),
}
"""Each with how its text is made, and n."""


def seconds(text: str) -> float:
    """Return the CPU time that reading and checking a text takes."""
    start = time.process_time()
    check_library(load_text(text))
    return time.process_time() - start


def laid_out(text: str) -> float:
    """Return the CPU time that laying out a text takes."""
    start = time.process_time()
    formatted(SourceFile("<text>", text))
    return time.process_time() - start


WORKS: Mapping[str, Callable[[str], float]] = {"": seconds, ", laid out": laid_out}
"""What is measured, by what is put behind the name of a construct."""


def rows(wanted: tuple[str, ...] = (), share: int = 1) -> Iterator[tuple[str, float]]:
    """Measure constructs, of an n divided by `share`; give a row and the growth."""
    for name, (make, n) in CONSTRUCTS.items():
        if wanted and not any(word in name for word in wanted):
            continue
        size = max(1, n // share)
        for what, work in WORKS.items():
            times = [work(make(size * step)) for step in STEPS]
            growth = times[-1] / times[0]
            mark = "**too much**" if growth > LIMIT else ""
            told = " | ".join(short(each) for each in times)
            yield (
                f"| {name}{what} | {size:,} | {told} | {growth:.1f} | {mark} |",
                growth,
            )


def main() -> None:
    """Read the command line and print a table."""
    parser = argparse.ArgumentParser(description="How checking grows with a text.")
    parser.add_argument("name", nargs="*", help="part of a construct's name")
    args = parser.parse_args()
    seconds(_raps(10))
    print("| construct | n | s for n | 2n | 4n | times as long | |")
    print("|---|---:|---:|---:|---:|---:|---|")
    for row, _ in rows(tuple(args.name)):
        print(row, flush=True)


if __name__ == "__main__":
    main()
