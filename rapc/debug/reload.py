"""Reload a library during a run, from files or from typed definitions.

The debugger saves the run, adapts the saved state, and restores the state in a run of
the new library. Three rules apply to the tasks of the run:

* A method under way keeps its old text. The method stays among the methods of its RAP
  with a context that never holds, so that the run can still be saved and restored.
* Every further choice uses the new text.
* The counts of tries of a task stay with methods of the same name.

The memory of a run depends on the declarations. Therefore the facts in memory, and the
requests and skills under way, must be valid for the new declarations.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from msgspec.structs import replace

from rapc.analysis.driver import CheckReport, check_library
from rapc.base.diagnostics import Severity
from rapc.base.names import plural
from rapc.base.source import SourceFile
from rapc.base.values import Fact, format_list
from rapc.compiler.program import Program
from rapc.compiler.rap_plan import MethodPlan
from rapc.debug.acts import Act, taken_up
from rapc.errors import RefusedError
from rapc.host import CheckedLibrary, CheckError
from rapc.ir import nodes
from rapc.ir.printer import format_goal, format_node
from rapc.ir.walk import variables
from rapc.library.library import KINDS, Library, digest
from rapc.library.loader import Loaded, load, load_sources
from rapc.library.signature import Signature
from rapc.parser.parse import parse
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving.codecs import Writer, fields_of
from rapc.runtime.saving.format import RunRecord, TaskRecord, decode_run
from rapc.runtime.state.states import BLOCKED, ENDED
from rapc.runtime.state.wait_state import WaitState
from rapc.world import Time

_NO_DEFINITIONS = ("methods", "files", "forms", "tests")
"""The fields of a library that do not affect a run; `raps` has the added methods."""


class TakeUp(Act, frozen=True, tag="reload"):
    """An act that reloads the library of a run."""

    program: Program
    #: The changed definitions: names, or the kind for definitions without a name.
    changed: tuple[str, ...]

    def do(self, run: Interpreter) -> Interpreter:
        """Restore the run with the new library.

        Raises:
            RefusedError: if the run cannot go on; the run is then unchanged.
            StateError: if the run cannot be saved.
        """
        record, before = decode_run(run.save()), run.library
        found = list(obstacles(record, before, self.program))
        if found:
            raise RefusedError(found)
        record = _moved(record, before, self.program)
        return taken_up(run, self.program, record)

    def __str__(self) -> str:
        names = " ".join(f"`{name}`" for name in self.changed)
        return f"reloaded {names or 'the same text'}"


def changed(before: Library, after: Library) -> tuple[str, ...]:
    """Return the names of changed definitions, in the order of their kinds."""
    return tuple(dict.fromkeys(name for _, name, _, _ in differing(before, after)))


def differing(
    before: Library, after: Library
) -> Iterator[tuple[str, str, nodes.Node | None, nodes.Node | None]]:
    """Yield each changed definition: kind, name, and its nodes before and after.

    The kinds without names, rules of memory for example, have the kind as the name.
    """
    words = {field: word for field, _, word in KINDS.values()}
    for field in before.__struct_fields__:
        old, new = getattr(before, field), getattr(after, field)
        kind = words.get(field, field.replace("_", " "))
        if field in _NO_DEFINITIONS or old == new:
            continue
        if isinstance(old, Mapping):
            for name in sorted({*old, *new}):
                if old.get(name) != new.get(name):
                    yield kind, name, old.get(name), new.get(name)
        else:
            yield from ((kind, kind, node, None) for node in old if node not in new)
            yield from ((kind, kind, None, node) for node in new if node not in old)


def _moved(record: RunRecord, before: Program, after: Program) -> RunRecord:
    """Return a saved run, adapted from one library to another."""
    retired: list[tuple[str, nodes.Method]] = []
    added: dict[str, list[nodes.Method]] = {}
    for name, node in record.added_methods:
        added.setdefault(name, []).append(node)
    tasks: list[TaskRecord | tuple[str, int]] = []
    again: list[int] = []
    for task in record.tasks:
        name = task[0] if isinstance(task, tuple) else task.plan
        old, new = before.library.raps[name], after.library.raps.get(name)
        if new is None:
            raise RefusedError([f"cannot remove `{name}`: its tasks are under way"])
        if new != old:
            _look_at_head(old, new)
        if isinstance(task, tuple):
            tasks.append(task)
            continue
        moved = _task(task, before, after, added, retired) if new != old else task
        moved = _waiting(moved, new, record.time)
        if moved.state == BLOCKED and moved.wait is not None:
            again.append(moved.number)
        tasks.append(moved)
    return replace(
        record,
        library=digest(after.library),
        tasks=tuple(tasks),
        added_methods=(*record.added_methods, *retired),
        to_test=tuple(dict.fromkeys((*record.to_test, *again))),
    )


def _waiting(task: TaskRecord, rap: nodes.DefineRap, now: Time) -> TaskRecord:
    """Return a task that waits for the monitors of the new RAP.

    The next test of the monitors registers the task for changes of facts. A time that
    the task waits for counts from its creation or from the end of its last method.
    Therefore an earlier time stays valid.
    """
    wait = task.wait
    if wait is None:
        if rap.monitor_state is None or task.state == ENDED:
            return task
        made = WaitState()
        made.made, made.first_selected = now, True
        wait = fields_of(WaitState).write(Writer(), made)
    if rap.monitor_time is None:
        wait = replace(wait, ready_at=0, monitor_deadline=None)
    return replace(task, wait=replace(wait, keys=False, formula=None))


def _look_at_head(old: nodes.DefineRap, new: nodes.DefineRap) -> None:
    """Validate that tasks of a RAP can go on with the new definition."""
    for field in ("inputs", "outputs", "resources"):
        if getattr(old, field) != getattr(new, field):
            raise RefusedError(
                [f"cannot change the {field} of `{old.name}`: its tasks are under way"]
            )


def _task(
    task: TaskRecord,
    before: Program,
    after: Program,
    added: Mapping[str, list[nodes.Method]],
    retired: list[tuple[str, nodes.Method]],
) -> TaskRecord:
    """Return a task with the methods of the new library."""
    olds = _methods(before, task.plan, added)
    news = _methods(after, task.plan, added)
    names = {name: at for at, (name, _) in enumerate(news)}

    def now(at: int | None) -> int | None:
        return None if at is None else names.get(olds[at][0])

    run, method = task.run, now(task.method)
    if run is not None:
        at = now(run.plan)
        node = olds[run.plan][1]
        if at is None or news[at][1] != node:
            at = len(news) + sum(1 for name, _ in retired if name == task.plan)
            retired.append((task.plan, replace(node, context=nodes.Truth(False))))
        run, method = replace(run, plan=at), at
    history = task.history
    if history is not None:
        counts = [(now(at), count) for at, count in history.failures]
        history = replace(
            history,
            choices=(),
            tries=(),
            last_choice=replace(history.last_choice, parts=()),
            before=now(history.before),
            failures=tuple([(at, n) for at, n in counts if at is not None]),
        )
    choice = None
    if task.choice is not None and method is not None:
        choice = replace(task.choice, parts=(method, *task.choice.parts[1:]))
    return replace(task, run=run, method=method, history=history, choice=choice)


def _methods(
    program: Program, rap: str, added: Mapping[str, list[nodes.Method]]
) -> list[tuple[str, nodes.Method]]:
    """Return the methods of a RAP with their names, solver methods last."""
    plan = program.known_rap(rap)
    found = [(method.name, method.node) for method in plan.methods]
    for node in added.get(rap, ()):
        made = MethodPlan(program.compiler, plan.node, node, len(found))
        found.append((made.name, node))
    return found


def obstacles(record: RunRecord, before: Program, after: Program) -> Iterator[str]:
    """Yield the reasons why a run cannot go on with new declarations, as lines.

    Args:
        record: the saved run.
        before: the present library of the run.
        after: the library with the new declarations.
    """
    beliefs, sets = record.memory.memory, record.memory.recognizer.sets
    for name, table in beliefs.facts.tables:
        old = before.signatures.relations[str(name)]
        new = after.signatures.relations.get(str(name))
        yield from _of_facts(old, new, [fact for fact, _ in table.stamps], after)
    state = record.state
    asked = [("is under way", fact) for _, (_, fact) in state.pending]
    yield from _declared_otherwise(
        asked, before.library.primitives, after.library.primitives
    )
    tables = state.activations
    activations = [one for _, one in (*tables.on, *tables.off)]
    on = [("is on", skill) for one in activations for skill in one.skills]
    yield from _declared_otherwise(on, before.library.skills, after.library.skills)
    known = {one.kind for one in (*beliefs.items.known, *sets)}
    old_classes, new_classes = before.library.indistinct, after.library.indistinct
    for kind in sorted(known):
        if old_classes.get(kind) != new_classes.get(kind):
            yield f"cannot change class `{kind}`: memory contains its items"


def _of_facts(
    old: Signature, new: Signature | None, facts: list[Fact], after: Program
) -> Iterator[str]:
    """Yield the reasons why facts in memory are invalid."""
    held = f"memory contains {plural(len(facts), 'fact')} of `{old.name}`"
    away = f"remove the facts with `:erase ({old.name})`"
    if new is None:
        yield f"{held}, which is no longer declared; {away}"
    elif (new.kind, new.most) != (old.kind, old.most):
        yield f"{held}, which is now the {new.kind} `{new.written}`; {away}"
    else:
        for fact in facts:
            wrong = after.signatures.wrong_kind("asserted", old.name, fact[1:])
            if wrong is not None:
                yield f"memory contains {format_list(fact)}: {wrong}"
                return


def _declared_otherwise(
    uses: list[tuple[str, Fact]],
    before: Mapping[str, object],
    after: Mapping[str, object],
) -> Iterator[str]:
    """Yield the requests and skills under way whose declarations changed."""
    for how, fact in uses:
        name = str(fact[0])
        if before.get(name) != after.get(name):
            yield (
                f"cannot change the declaration of `{name}`: {format_list(fact)} {how}"
            )


TYPED = "<typed>"
"""The file name of typed definitions."""


class Renewed(NamedTuple):
    """A reloaded library and its check report."""

    library: CheckedLibrary
    report: CheckReport


def reread(paths: Iterable[str], typed: str, name: str) -> Renewed:
    """Read files again; typed definitions replace those of the same names.

    Raises:
        LoadError: if a file cannot be read.
        CheckError: if the checker reports an error.
    """
    loaded = load(list(paths))
    if typed:
        loaded = load_sources(_with(loaded.files, typed))
    return checked(loaded, name)


def typed_in(library: Library, typed: str, name: str) -> Renewed:
    """Return a library in which typed definitions replace those of the same names.

    Raises:
        CheckError: if the checker reports an error.
    """
    return checked(load_sources(_with(library.files, typed)), name)


def checked(loaded: Loaded, name: str) -> Renewed:
    """Return a library without errors, with its check report.

    Raises:
        CheckError: if the checker reports an error.
    """
    report = check_library(loaded)
    errors = [f for f in report.findings if f.severity is Severity.ERROR]
    if errors:
        raise CheckError(CheckReport(tuple(errors), report.files))
    return Renewed(CheckedLibrary(Program(loaded.library, name)), report)


def _with(files: Mapping[str, SourceFile], typed: str) -> list[SourceFile]:
    """Return the files, with the definitions in `typed` moved to a file of their own.

    Blanks replace the old definitions, so that all positions stay valid.

    Raises:
        RefusedError: if several rules in the files match one typed rule.
    """
    source = SourceFile(TYPED, typed)
    names = Counter(map(_named, parse(source).forms))
    found: list[SourceFile] = []
    replaced: Counter[tuple[str, str]] = Counter()
    for file in files.values():
        text = file.text
        for form in parse(file).forms:
            name = _named(form)
            if name in names:
                replaced[name] += 1
                start, end = form.span.start, form.span.end
                blank = "".join(c if c == "\n" else " " for c in text[start:end])
                text = text[:start] + blank + text[end:]
        if file.name != TYPED:
            found.append(file if text == file.text else SourceFile(file.name, text))
    for key, count in replaced.items():
        if key[0] in _RULES and count > names[key]:
            raise RefusedError(
                [
                    f"cannot replace rule `{key[1]}`: {count} rules have this pattern; "
                    f"enter {count} rules in one input"
                ]
            )
    return [*found, source]


_RULES = (nodes.MemoryRule.__name__, nodes.EventRule.__name__)


def definitions(text: str) -> dict[tuple[str, str], str]:
    """Return the definitions in a text, each by kind and name; see `_named`."""
    found: dict[tuple[str, str], list[str]] = {}
    for form in parse(SourceFile(TYPED, text)).forms:
        said = text[form.span.start : form.span.end]
        found.setdefault(_named(form), []).append(said)
    return {named: "\n".join(forms) for named, forms in found.items()}


def _named(form: nodes.TopForm) -> tuple[str, str]:
    """Return the kind and name of a definition; of a rule the pattern and the phase."""
    kind = type(form).__name__
    if isinstance(form, nodes.DefineMethod):
        named = form.method.name is not None
        method = form.method.name if named else format_node(form.method)
        return kind, f"{form.rap} {method}"
    if isinstance(form, nodes.MemoryRule):
        return kind, f"{_pattern(form.index)} :{form.when}"
    if isinstance(form, nodes.EventRule):
        return kind, _pattern(nodes.Goal(form.signal, form.args, ()))
    if isinstance(form, nodes.DeclareComparator):
        return kind, f"{form.class_name} {form.place}"
    return kind, form.name


def _pattern(goal: nodes.Goal) -> str:
    """Return a pattern as text in which the names of the variables do not matter."""
    terms = (*goal.args, *goal.outputs)
    uses = Counter(one.name for one in variables(*terms) if not one.anonymous)
    names = {name: f"?{at}" for at, name in enumerate(uses, 1) if uses[name] > 1}
    return format_goal(goal, {name: names.get(name, "?") for name in uses})
