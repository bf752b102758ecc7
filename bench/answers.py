"""Answers of the debugger at the last cycle of a long run: processor time of each.

    python -m bench.answers
    python -m bench.answers --rounds 9

The run is nine orders of the truck with `truck.shuffle-interval=15` and seed 1: 7,977
cycles. Before each round the session goes to the last cycle. A figure is the median of
the rounds, with the garbage collector on; a line above 100 ms is marked.
"""

from __future__ import annotations

import argparse
import statistics
import time

import rapc
from rapc.debug.history import History
from rapc.repl.commands.table import commands
from rapc.repl.shell import Shell

MOST = 100
"""The time of an answer in milliseconds that is not marked."""

QUESTIONS = (
    ":back",
    ":back 1000",
    ":goto 100",
    ":goto 4000",
    ":goto at 3000",
    ":goto at 6270",
    ":goto end",
    ":why",
    ":why failed",
    ":why-not",
    ":who (location ? ?)",
    ":history (truck-location ?)",
    ":timeline",
    ":timeline 6175",
    ":waits",
    ":waits 3",
    ":idle (arm arm1)",
    ":retries",
    ":deadlines",
    ":trace 20",
    ":what-if (erase (truck-status))",
    ":diff 7976",
    ":diff 4000",
    ":find back task-failed",
    ":memory",
    ":world",
)
"""The inputs that are measured."""


def session() -> History:
    """Return the run, at its end."""
    library = rapc.load("stdlib/truck")
    options = {"shuffle-interval": 15}
    found = History.open(
        library, "truck", agenda="nine-orders", seed=1, options=options
    )
    found.go()
    return found


def taken(shell: Shell, question: str, rounds: int) -> float:
    """Return the median of the time that an answer takes, in milliseconds."""
    times = []
    for _ in range(rounds):
        shell.answer(":goto end")
        shell.answer(":back")
        before = time.process_time()
        answer = shell.answer(question)
        times.append((time.process_time() - before) * 1000)
        assert not answer.failed, (question, answer.lines)
    return statistics.median(times)


def main() -> None:
    """Print a line for each question."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    history = session()
    shell = Shell(history, commands())
    print(f"nine orders, seed 1, {history.cycle} cycles: {rounds} rounds each")
    for question in QUESTIONS:
        time_taken = taken(shell, question, rounds)
        mark = "  above the bar" if time_taken > MOST else ""
        print(f"{question:32} {time_taken:8.1f} ms{mark}", flush=True)


if __name__ == "__main__":
    main()
