"""A few declarations, and memories about it in two forms, changed in step."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

from rapc.base.values import Fact
from rapc.compiler.query.query import Query
from rapc.events import Event, QueryFaulted
from rapc.ir import nodes
from rapc.library.loader import load_text
from rapc.library.signatures import Signatures
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.memory.memory import Memory
from rapc.runtime.query_context import QueryContext
from rapc.runtime.state.task import Task

from .reference import Mind

PROPERTIES: Mapping[str, tuple[int, str]] = {
    "color": (2, "unknown"),
    "heavy": (2, "false"),
    "size": (2, "zero"),
    "power": (1, "true"),
    "wire": (3, "unknown"),
    "location": (2, "unknown"),
    "class": (3, "false"),
}
PROPOSITIONS: Mapping[str, int] = {"p": 1, "q": 2, "r": 0, "s": 3}


def _args(count: int) -> str:
    return " ".join(f"?arg{at}" for at in range(count))


_DECLARATIONS = "\n".join(
    [
        *[
            f"(declare-memory-property {name} ({_args(count)}) {default})"
            for name, (count, default) in PROPERTIES.items()
        ],
        *[
            f"(declare-memory-proposition {name} ({_args(count)}))"
            for name, count in PROPOSITIONS.items()
        ],
        "(declare-memory-function odd :reads ())",
        "(declare-memory-function zero (?index) :reads ())",
        "(declare-memory-function next-to :reads ())",
    ]
)

LIBRARY = load_text(_DECLARATIONS).library
SIGNATURES = Signatures.of(LIBRARY)

FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "odd": lambda view, number: isinstance(number, int) and number % 2 == 1,
    "next-to": lambda view, thing: f"{thing}'",
    "zero": lambda view, index: 0,
}


@dataclass
class Memories:
    """One and the same memory, as it is in a run and as the reference has it."""

    memory: Memory
    access: MemoryAccess
    recorder: Recorder
    context: QueryContext
    mind: Mind


Change = tuple[str, Any]
"""What is done to a memory: a verb and its operand."""


def memories(changes: list[Change]) -> Memories:
    """Both memories after some changes."""
    recorder = Recorder()
    access = MemoryAccess(LIBRARY, SIGNATURES, recorder, {})
    memory = access.memory
    context = QueryContext(memory, recorder, FUNCTIONS)
    context.task = _task()
    mind = Mind(
        PROPERTIES,
        PROPOSITIONS,
        tried=("one", 2),
        results={"one": "okay", 2: "dropped"},
        last_result="dropped",
    )
    both = Memories(memory, access, recorder, context, mind)
    for change in changes:
        apply(both, change)
    return both


def _task() -> Task:
    """All of a task that a formula can ask about."""
    history = {"one": "okay", 2: "dropped"}
    stand_in = SimpleNamespace(
        number=1,
        has_tried=history.__contains__,
        result_of=history.get,
        last_result="dropped",
    )
    return cast(Task, stand_in)


def erase(both: Memories, prefix: Fact) -> None:
    """Remove the facts that start with a prefix from the memory of a run."""
    for fact in both.memory.facts.starting(prefix):
        both.memory.remove(fact, "test")


def apply(both: Memories, change: Change) -> None:
    """Make one change to both memories."""
    verb, what = change
    mind = both.mind
    if verb == "assert":
        both.memory.store(both.memory.checked(what), "test")
        mind.add(both.memory.checked(what))
    elif verb == "erase":
        erase(both, what)
        mind.erase(what)
    elif verb == "wait":
        both.recorder.time += what
        mind.now += what
    elif verb == "arrive":
        both.access.arrive(what)
        mind.place = what
    elif verb == "expire":
        both.access.expire()
        mind.items = dict.fromkeys(mind.items, False)
    else:
        name, place = what
        both.access.introduce(name, "thing", place)
        if not mind.items.get(name):
            mind.items.pop(name, None)
        mind.items[name] = True
        mind.kinds[name] = "thing"
        mind.add(("class", name, "thing", "true"))
        known = mind.place is not None and place == "external"
        mind.add(("location", name, mind.place if known else place))  # type: ignore[arg-type]


class Faults(list[str]):
    """Collects the faults of queries."""

    def __call__(self, event: Event) -> None:
        if isinstance(event, QueryFaulted):
            self.append(event.what)


def query(formula: nodes.Formula) -> Query:
    """A formula, ready to be asked."""
    return Query(formula, SIGNATURES, "clause")
