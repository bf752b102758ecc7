"""Another text of the library while a run goes on.

A method that is under way keeps the text that it began with: it stays among the methods
of its RAP, with a context that never holds, so that it is saved and taken up like any
other. Whatever is chosen from now on is chosen from the new text. What a task has tried
stays with methods of the same name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from msgspec.structs import replace

from rapc.analysis.driver import CheckReport, check_library
from rapc.base.diagnostics import Severity
from rapc.base.source import SourceFile
from rapc.compiler.program import Program
from rapc.compiler.rap_plan import MethodPlan
from rapc.debug.acts import Act
from rapc.errors import RefusedError, StateError
from rapc.host import CheckedLibrary, CheckError
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.loader import Loaded, load, load_sources
from rapc.parser.parse import parse
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving.format import decode, digest, encode
from rapc.runtime.saving.records import Parts, RunRecord, TaskRecord

TYPED = "<typed>"
"""The file name of definitions that were typed."""

_FREE = ("raps", "queries", "agendas", "files", "forms", "tests")
"""What may change while a run goes on; all else is built into its memory."""


class TakeUp(Act, frozen=True):
    """Lets a run go on with another text of its library."""

    program: Program
    #: The names of the RAPs whose text is another.
    changed: tuple[str, ...]

    def do(self, run: Interpreter) -> None:
        """Take up the new text.

        Raises:
            RefusedError: if the run cannot go on with it; then nothing has changed.
            StateError: if the run cannot be saved.
        """
        machine = run.machine
        before = machine.library
        saved = _moved(decode(run.save()), before, self.program)
        machine.library = self.program
        try:
            run.restore(encode(saved))
        except StateError:
            machine.library = before
            raise

    def __str__(self) -> str:
        return f"take up {' '.join(self.changed) or 'the same text'}"


def changed_raps(before: Library, after: Library) -> tuple[str, ...]:
    """Return the names of the RAPs and queries that differ, sorted."""
    names = {*before.raps, *after.raps, *before.queries, *after.queries}
    return tuple(
        sorted(
            name
            for name in names
            if before.raps.get(name) != after.raps.get(name)
            or before.queries.get(name) != after.queries.get(name)
        )
    )


def take_up(run: Interpreter, after: CheckedLibrary) -> TakeUp:
    """Return the act by which a run goes on with another text of its library.

    Raises:
        RefusedError: if more than RAPs, queries and agendas has changed.
    """
    old, new = run.machine.library.library, after.program.library
    other = [
        field
        for field in old.__struct_fields__
        if field not in _FREE and getattr(old, field) != getattr(new, field)
    ]
    if other:
        raise RefusedError(
            [
                f"declarations have changed ({', '.join(other)}): they are built into "
                "the memory of a run, which must be begun anew"
            ]
        )
    return TakeUp(after.program, changed_raps(old, new))


def _moved(record: RunRecord, before: Program, after: Program) -> RunRecord:
    """Return a saved run of one text as a run of another."""
    retired: list[tuple[str, nodes.Method]] = []
    added: dict[str, list[nodes.Method]] = {}
    for name, node in record.added_methods:
        added.setdefault(name, []).append(node)
    changed = set(changed_raps(before.library, after.library))
    tasks = []
    for task in record.tasks:
        if task.rap not in after.library.raps:
            raise RefusedError([f"tasks of `{task.rap}` are under way: it must stay"])
        if task.rap in changed:
            _look_at_head(before, after, task.rap)
            task = _task(task, before, after, added, retired)  # noqa: PLW2901  # renewed
        tasks.append(task)
    return replace(
        record,
        library=digest(after.library),
        tasks=tuple(tasks),
        added_methods=(*record.added_methods, *retired),
    )


def _look_at_head(before: Program, after: Program, name: str) -> None:
    """See that tasks of a RAP can go on with another text of it."""
    old, new = before.library.raps[name], after.library.raps[name]
    for field in ("inputs", "outputs", "resources"):
        if getattr(old, field) != getattr(new, field):
            raise RefusedError(
                [f"tasks of `{name}` are under way: its {field} must stay"]
            )


def _task(
    task: TaskRecord,
    before: Program,
    after: Program,
    added: Mapping[str, list[nodes.Method]],
    retired: list[tuple[str, nodes.Method]],
) -> TaskRecord:
    """Return a task whose methods are those of the new text."""
    olds = _methods(before, task.rap, added)
    news = _methods(after, task.rap, added)
    names = {name: at for at, (name, _) in enumerate(news)}

    def now(at: int | None) -> int | None:
        return None if at is None else names.get(olds[at][0])

    run, method = task.run, now(task.method)
    if run is not None:
        at = now(run.method)
        node = olds[run.method][1]
        if at is None or news[at][1] != node:
            at = len(news) + sum(1 for name, _ in retired if name == task.rap)
            retired.append((task.rap, replace(node, context=nodes.Truth(False))))
        run, method = replace(run, method=at), at
    history = task.history
    if history is not None:
        counts = [(now(at), count) for at, count in history.failures]
        history = replace(
            history,
            choices=(),
            last_choice=None,
            before=now(history.before),
            failures=tuple([(at, n) for at, n in counts if at is not None]),
        )
    choice = None
    if task.choice is not None and method is not None:
        choice = Parts((method, *task.choice.parts[1:]))
    return replace(task, run=run, method=method, history=history, choice=choice)


def _methods(
    program: Program, rap: str, added: Mapping[str, list[nodes.Method]]
) -> list[tuple[str, nodes.Method]]:
    """Return the methods of a RAP, those of solvers behind them, by their names."""
    plan = program.known_rap(rap)
    found = [(method.name, method.node) for method in plan.methods]
    for node in added.get(rap, ()):
        made = MethodPlan(program.compiler, plan.node, node, len(found))
        found.append((made.name, node))
    return found


# --- texts --------------------------------------------------------------------------


class Renewed(NamedTuple):
    """Another text of a library, and what was found in it."""

    library: CheckedLibrary
    report: CheckReport


def reread(paths: Iterable[str], typed: str, name: str) -> Renewed:
    """Read files again, with the definitions that were typed in place of theirs.

    Raises:
        LoadError: for what cannot be read.
        CheckError: if anything of severity error is found.
    """
    loaded = load(list(paths))
    if typed:
        loaded = load_sources(_with(loaded.files, typed))
    return _checked(loaded, name)


def typed_in(library: Library, typed: str, name: str) -> Renewed:
    """Return a library with typed definitions in place of those of the same names.

    Raises:
        CheckError: if anything of severity error is found.
    """
    return _checked(load_sources(_with(library.files, typed)), name)


def _checked(loaded: Loaded, name: str) -> Renewed:
    report = check_library(loaded)
    errors = [f for f in report.findings if f.severity is Severity.ERROR]
    if errors:
        raise CheckError(CheckReport(tuple(errors), report.files))
    return Renewed(CheckedLibrary(Program(loaded.library, name)), report)


def _with(files: Mapping[str, SourceFile], typed: str) -> list[SourceFile]:
    """Return files without the definitions that were typed anew, and those.

    What is left out is blanked, so that all else stays where it was.
    """
    source = SourceFile(TYPED, typed)
    names = names_of(typed)
    found = []
    for file in files.values():
        if file.name == TYPED:
            continue
        text = file.text
        for form in parse(file).forms:
            if _named(form) in names:
                start, end = form.span.start, form.span.end
                blank = "".join(c if c == "\n" else " " for c in text[start:end])
                text = text[:start] + blank + text[end:]
        found.append(file if text == file.text else SourceFile(file.name, text))
    return [*found, source]


def names_of(text: str) -> frozenset[tuple[str, str]]:
    """Return what tells the definitions of a text from others: kind and name."""
    return frozenset(map(_named, parse(SourceFile(TYPED, text)).forms))


def _named(form: nodes.TopForm) -> tuple[str, str]:
    return type(form).__name__, str(getattr(form, "name", ""))
