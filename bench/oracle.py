"""Write what rapc answers to many inputs into a folder, to compare two states of it.

    python -m bench.oracle before --tree ../before
    python -m bench.oracle after
    diff -r before after

`--every 10` takes one input of ten, for a look between two edits: the same ones in
each checkout.

Each answer is a file, so `diff -r` names what changed. `--tree` is the checkout whose
rapc answers; the inputs always come from this checkout. All answers are made with the
command line and the public Python names, which stay while the code behind them moves.

- `findings`: rules, positions and fixes that `rapc check` reports.
- `messages`: the texts of these findings.
- `fmt`: the layout of each file.
- `explain`: how the compiler evaluates the clauses of each shipped RAP.
- `generated`: the Python code that runs generate from queries.
- `traces`: a digest of each cycle of seeded runs with faults and acts of a host.
- `restored`: the same, of runs that go on from a saved state.
- `transcripts`: answers of the debugger on terminals of three widths, and as JSON.
- `reference`: the verdicts of the second interpreter.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import re
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from io import StringIO
from multiprocessing import get_context
from os import openpty
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from tests import slips_said
from tests.damage import with_other_parenthesis

HERE = Path(__file__).resolve().parent.parent
"""The checkout whose texts are the inputs."""

WIDTHS = (40, 80, 200)
"""Columns of the terminal for the transcripts."""

BROKEN_TEXTS = 400
"""Texts with a parenthesis dropped or doubled."""

REFERENCE_SEEDS = 5000


class Answer(NamedTuple):
    """One file of the oracle: its path below the folder and its text."""

    path: str
    text: str


# --- the command line -----------------------------------------------------------------


def command(
    *args: str, stdin: str = "", cwd: Path = HERE, columns: int | None = None
) -> str:
    """Run `rapc` in a fork of this process; return status, output and errors.

    The output goes to a terminal of so many `columns`, or to a file.
    """
    with TemporaryDirectory() as scratch:
        names = [str(Path(scratch, name)) for name in ("in", "out", "err")]
        Path(names[0]).write_text(stdin, encoding="utf-8")
        reader, terminal = openpty() if columns else (-1, -1)
        child = os.fork()
        if not child:
            os.environ["COLUMNS"] = str(columns or 80)
            _become_command(args, names, cwd, terminal)
        drawn = _drained(reader, terminal) if columns else ""
        _, status = os.waitpid(child, 0)
        out, err = (Path(name).read_text("utf-8", "replace") for name in names[1:])
    out = drawn or out
    return f"exit {os.waitstatus_to_exitcode(status)}\n{out}\n--- errors\n{err}"


def _drained(reader: int, terminal: int) -> str:
    """Return the output of a terminal, when all its writers have closed it."""
    os.close(terminal)
    drawn = b""
    with suppress(OSError), open(reader, "rb", buffering=0) as stream:
        while part := stream.read(65536):
            drawn += part
    return drawn.decode("utf-8", "replace").replace("\r\n", "\n")


def _become_command(
    args: Iterable[str], files: list[str], cwd: Path, terminal: int
) -> None:
    """Replace the streams of a fork, run the command and end the process.

    The output goes to `terminal`, or to a file where that is -1.
    """
    from rapc.cli import main  # noqa: PLC0415  # of the tree that is asked

    os.dup2(os.open(files[0], os.O_RDONLY), 0)
    for number, name in ((1, files[1]), (2, files[2])):
        os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT), number)
    if terminal >= 0:
        os.dup2(terminal, 1)
        os.close(terminal)
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115  # until the end
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    os.environ.update(RAPC_CACHE_DIR=os.devnull, NO_COLOR="1", TERM="dumb")
    os.chdir(cwd)
    sys.argv = ["rapc", *args]
    status = 0
    try:
        main.main()
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1
    except BaseException as error:  # a fault of rapc is an answer, too
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        status = 70
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


# --- texts ----------------------------------------------------------------------------


def files() -> list[Path]:
    """Return all RAP files of the checkout."""
    rooms = [HERE / name for name in ("stdlib", "examples", "tests", "docs")]
    return sorted(path for room in rooms for path in room.rglob("*.rap"))


def slips() -> Iterator[tuple[str, str]]:
    """Yield the programs with one slip that the tests describe, with names."""
    for path in sorted((HERE / "tests/analysis/near").glob("*.rap")):
        for number, slip in enumerate(slips_said.slips(path.read_text("utf-8"))):
            yield f"{path.stem}-{number}", slip.text


def pages() -> Iterator[tuple[str, str]]:
    """Yield the blocks of RAP text in the documentation, with names."""
    block = re.compile(r"^```rap\n(.*?)^```", re.DOTALL | re.MULTILINE)
    for path in sorted((HERE / "docs").rglob("*.md")):
        blocks = block.findall(path.read_text(encoding="utf-8"))
        for number, text in enumerate(blocks):
            name = "-".join(path.relative_to(HERE / "docs").with_suffix("").parts)
            yield f"{name}-{number}", text


def broken() -> Iterator[tuple[str, str]]:
    """Yield files with one parenthesis dropped or doubled."""
    chance = random.Random(5)
    texts = [
        p.read_text("utf-8") for p in files() if p.parts[-3:-1] != ("tests", "rap")
    ]
    for number in range(BROKEN_TEXTS):
        text, _ = with_other_parenthesis(chance.choice(texts), chance)
        yield f"{number:03}", text


# --- sections -------------------------------------------------------------------------


def findings_of(name: str, args: tuple[str, ...], text: str) -> list[Answer]:
    """Check a library: what is found where, and in which words."""
    options = ("check", "--isolated", "--no-cache", "--output-format", "json")
    said = command(*options, *args, stdin=text)
    status, _, rest = said.partition("\n")
    body = rest.partition("\n--- errors\n")[0]
    try:
        rows = json.loads(body)
    except ValueError:
        return [Answer(f"findings/{name}", said)]
    places, words = [status], [status]
    for row in rows:
        words.append(json.dumps(row, sort_keys=True, ensure_ascii=False))
        places.append(json.dumps(_without_words(row), sort_keys=True))
    return [
        Answer(f"findings/{name}", "\n".join(places) + "\n"),
        Answer(f"messages/{name}", "\n".join(words) + "\n"),
    ]


WORDS = frozenset({"message", "notes", "help", "label", "text", "title", "summary"})
"""Keys of a finding that hold a text for people."""


def _without_words(value: Any) -> Any:
    """Return a finding without the texts for people; edits keep their content."""
    if isinstance(value, dict):
        kept = {key: part for key, part in value.items() if key not in WORDS}
        return {key: _without_words(part) for key, part in kept.items()}
    if isinstance(value, list):
        return [_without_words(part) for part in value]
    return value


def layout_of(name: str, path: str) -> list[Answer]:
    """Lay out a file."""
    text = Path(path).read_text(encoding="utf-8")
    return [Answer(f"fmt/{name}", command("fmt", "-", stdin=text))]


def explained(library: str, rap: str) -> list[Answer]:
    """Explain how the clauses of a RAP are evaluated."""
    return [
        Answer(
            f"explain/{library}-{rap}", command("compile", library, "--explain", rap)
        )
    ]


class RunCase(NamedTuple):
    """A seeded run: a library, a world, what to do and the options of the world."""

    name: str
    library: str
    world: str
    agenda: str | None
    tasks: tuple[str, ...]
    options: tuple[tuple[str, Any], ...]
    until: float
    seeds: int
    acts: tuple[tuple[str, ...], ...]


RUNS = (
    RunCase(
        "truck",
        "stdlib/truck",
        "truck",
        None,
        ("(fill-order red 2 factory-1)", "(fill-order blue 1 factory-2)"),
        (),
        400,
        150,
        (
            ("submit", "(wakeup) :priority 4"),
            ("cancel", "fill-order", "blue", "?", "?"),
        ),
    ),
    RunCase(
        "truck-hard",
        "stdlib/truck",
        "truck",
        "nine-orders",
        (),
        (("arm1-drops", 20), ("arm2-drops", 20)),
        250,
        150,
        (("submit", "(fill-order red 1 factory-3)"), ("assert_fact", "rubbish", "x")),
    ),
    RunCase(
        "hallway",
        "stdlib/hallway",
        "hallway",
        "errand",
        (),
        (),
        60,
        100,
        (("signal", ":movement-complete"),),
    ),
    RunCase(
        "courier",
        "examples/courier",
        "courier",
        "shift",
        (),
        (),
        700,
        100,
        (("signal", ":nurse", "ward-1"), ("erase", "rubbish")),
    ),
)


def traced(case: RunCase, seed: int) -> list[Answer]:
    """Run with acts of a host at random cycles; save once and go on from there."""
    import rapc  # noqa: PLC0415  # of the tree that is asked

    library = rapc.load(HERE / case.library)
    stream = StringIO()
    run = _begun(rapc, library, case, seed, stream)
    chance = random.Random(seed)
    moments = sorted(chance.sample(range(5, 80), len(case.acts)))
    acts = dict(zip(moments, case.acts, strict=True))
    half = chance.randrange(30, 90)
    saved, before = None, 0
    cycle = 0
    while run.now < case.until and run.step():
        cycle += 1
        if cycle in acts:
            stream.write(f"act {acts[cycle]}: {_acted(rapc, run, *acts[cycle])}\n")
        if cycle == half and seed % 5 == 0:
            saved, before = run.save(), stream.tell()
    stream.write(f"end {run.now}: {_results(run)}\n")
    told = stream.getvalue()
    found = [
        Answer(f"traces/{case.name}/{seed:03}", _digests(told.replace(f"{HERE}/", "")))
    ]
    if saved is not None and not any(cycle > half for cycle in acts):
        stream = StringIO()
        other = _begun(rapc, library, case, seed, stream)
        other.restore(saved)
        stream.truncate(0)
        stream.seek(0)
        while other.now < case.until and other.step():
            pass
        stream.write(f"end {other.now}: {_results(other)}\n")
        same = stream.getvalue() == told[before:]
        text = f"equal to the run that was saved: {same}\n"
        found.append(Answer(f"restored/{case.name}/{seed:03}", text))
    return found


def generated(case: RunCase) -> list[Answer]:
    """Run once, and return the code that was compiled under a name of no file."""
    import rapc  # noqa: PLC0415  # of the tree that is asked

    sources: set[str] = set()

    def note(event: str, args: tuple[Any, ...]) -> None:
        if event == "compile" and str(args[1]).startswith("generated-"):
            source = args[0].decode() if isinstance(args[0], bytes) else args[0]
            sources.add(source)

    sys.addaudithook(note)
    library = rapc.load(HERE / case.library)
    run = _begun(rapc, library, case, 0, StringIO())
    while run.now < case.until and run.step():
        pass
    text = "\n\n# ---\n\n".join(sorted(sources))
    return [Answer(f"generated/{case.name}", text)]


def _begun(rapc: Any, library: Any, case: RunCase, seed: int, stream: StringIO) -> Any:
    """Begin a run whose events are written to `stream`, as lines of JSON."""
    return library.start(
        case.world,
        agenda=case.agenda,
        tasks=case.tasks,
        seed=seed,
        options=dict(case.options),
        listeners=[rapc.JsonTrace(stream)],
    )


def _acted(rapc: Any, run: Any, verb: str, *args: str) -> str:
    """Carry out an act of a host; return how it ended."""
    try:
        getattr(run, verb)(*([args] if verb == "cancel" else args))
    except rapc.Error as error:
        return type(error).__name__
    return "done"


def _results(run: Any) -> list[str]:
    return [f"{task.outcome} {task.ended}" for task in run.results()]


def _digests(trace: str) -> str:
    """Return one digest for each 20 events: a difference has a place."""
    lines = trace.splitlines()
    blocks = ["\n".join(lines[i : i + 20]) for i in range(0, len(lines), 20)]
    return "".join(f"{hashlib.sha256(b.encode()).hexdigest()[:16]}\n" for b in blocks)


QUESTIONS = (
    *(":agenda", ":tree", ":chain", ":task", ":memory", ":memory (location ?x ?y)"),
    *(":items", ":monitors", ":claims", ":requests", ":stack", ":skills", ":world"),
    *(":why", ":why-not", ":when chosen", ":history truck-location", ":retries"),
    *(":who (truck-location factory-1)", ":deadlines", ":timeline", ":trace 3"),
    *(":why failed", ":source", ":branches", ":option", ":watch (location ?x ?y)"),
    *(":what-if (erase (location)) 3", "(location ?x ?y)", ":more", ":help :why"),
)
"""What the debugger is asked at each moment of the transcripts."""

DEBUGGED = (
    (
        ("stdlib/truck", "--world", "truck", "--task", "(fill-order red 2 factory-1)"),
        40,
    ),
    (("examples/courier", "--world", "courier", "--agenda", "shift"), 60),
    (("stdlib/hallway", "--world", "hallway", "--agenda", "errand"), 30),
)
"""Runs for the transcripts, with the cycles to step."""

MOVES = (
    *(
        ":break rap load-rock log",
        ":primitive",
        ":out",
        ":back 3",
        ":goto 10",
        ":to 20",
    ),
    *(":branch other", ":assert (location nothing nowhere)", ":submit (wakeup)"),
    *(
        ":force (?any) okay",
        ":step 5",
        ":diff 10",
        ":find task-failed",
        ":find back task",
    ),
    *(
        ":cancel (wakeup)",
        ":fail",
        ":retry",
        ":signal (unheard)",
        ":goto end",
        ":parent",
    ),
    *(":break", ":unbreak all", ":unwatch all", ":show requests", ":run", ":agenda"),
    *(":no-such", ":step x", ":why 9999", ":goto -1", ":history", "(no-such ?x)", "(("),
)
"""What moves the runs of the transcripts, with inputs that are refused."""


def transcript(number: int, columns: int) -> list[Answer]:
    """Ask and move a run in the debugger."""
    args, cycles = DEBUGGED[number]
    typed = [f":step {cycles}", *QUESTIONS, *MOVES, *QUESTIONS]
    said = command("repl", *args, stdin="\n".join(typed) + "\n", columns=columns)
    rows = command("repl", *args, "--json", stdin="\n".join(typed) + "\n")
    found = [Answer(f"transcripts/{number}-{columns}", said)]
    return [*found, Answer(f"transcripts/{number}-json", rows)]


def reference(tree: str) -> list[Answer]:
    """Compare random programs with the second interpreter of a tree, without time."""
    args = ["-m", "tests.reference.compare", "--seeds", str(REFERENCE_SEEDS)]
    done = subprocess.run(
        [sys.executable, *args], cwd=tree, capture_output=True, text=True, check=False
    )
    said = re.sub(r", \d+ s:", ":", done.stdout)
    return [Answer("reference/programs", f"exit {done.returncode}\n{said}")]


# --- all of it ------------------------------------------------------------------------


class Job(NamedTuple):
    """A function that makes answers, with its arguments."""

    make: Callable[..., list[Answer]]
    args: tuple[Any, ...]


def jobs(tree: str) -> Iterator[tuple[str, Job]]:
    """Yield all jobs with the section that each belongs to, the longest ones first."""
    yield "reference", Job(reference, (tree,))
    for case in RUNS:
        for seed in range(case.seeds):
            yield "traces", Job(traced, (case, seed))
        yield "generated", Job(generated, (case,))
    for number in range(len(DEBUGGED)):
        for columns in WIDTHS:
            yield "transcripts", Job(transcript, (number, columns))
    for library in ("stdlib", "examples"):
        yield "findings", Job(findings_of, (library, (library,), ""))
    for path in files():
        name = "-".join(path.relative_to(HERE).parts)
        yield "findings", Job(findings_of, (name, (str(path.relative_to(HERE)),), ""))
        yield "fmt", Job(layout_of, (name, str(path)))
    for kind, texts in (("slip", slips()), ("page", pages()), ("broken", broken())):
        for name, text in texts:
            yield "findings", Job(findings_of, (f"{kind}-{name}", ("-",), text))
    for rule in json.loads(
        command("rule", "--all", "--format", "json")[7:].split("\n--")[0]
    ):
        for key in ("example", "better"):
            args = ("--select", rule["code"], "-")
            name = f"rule-{rule['name']}-{key}"
            yield "findings", Job(findings_of, (name, args, rule[key]))
    for library in ("stdlib/truck", "stdlib/hallway", "examples/courier"):
        text = "".join(
            p.read_text("utf-8") for p in sorted((HERE / library).glob("*.rap"))
        )
        for rap in sorted(set(re.findall(r"\(define-rap \(([^\s()]+)", text))):
            yield "explain", Job(explained, (library, rap))


def _number(job: Job) -> int:
    """Return a number of a job that is the same in each checkout."""
    return zlib.crc32(repr(job.args).replace(str(HERE), "").encode())


def _made(job: Job) -> list[Answer]:
    return job.make(*job.args)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder for the answers")
    parser.add_argument("--tree", default=str(HERE), help="checkout that answers")
    parser.add_argument("--only", nargs="*", help="sections, for example traces fmt")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--every", type=int, default=1, help="take one input of N")
    chosen = parser.parse_args()
    sys.path.insert(0, str(Path(chosen.tree).resolve()))
    import rapc  # noqa: PLC0415  # of the tree that is asked
    import rapc.cli.main  # noqa: PLC0415

    if not Path(rapc.__file__).is_relative_to(Path(chosen.tree).resolve()):
        sys.exit(f"rapc is imported from {rapc.__file__}: set PYTHONPATH to --tree")
    wanted = [
        job
        for section, job in jobs(chosen.tree)
        if not chosen.only or section in chosen.only
    ]
    wanted = [job for job in wanted if not _number(job) % chosen.every]
    count = 0
    with ProcessPoolExecutor(chosen.jobs, mp_context=get_context("fork")) as pool:
        for answers in pool.map(_made, wanted):
            for answer in answers:
                path = chosen.folder / answer.path.replace("*", "_")
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(answer.text, encoding="utf-8")
                count += 1
    print(f"{count} answers in {chosen.folder}")


if __name__ == "__main__":
    main()
