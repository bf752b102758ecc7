"""Changes of memory without a handler in Python: by declarations, and as data.

A result or a datum without a handler is carried out by its declaration, if `:on` names
all facts. A world may also send the changes with a result or a datum, as data
(`rapc.world.Change`); they apply after the handler, or in place of the declaration.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from rapc.base.values import Atom, Fact, format_list
from rapc.errors import FactError, PortError
from rapc.ir import nodes
from rapc.library.effects import named_effects
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.memory.recognition.sets import UNKNOWN
from rapc.runtime.run import Run
from rapc.world import Change, Handlers


def add_declared(run: Run) -> None:
    """Add handlers for the results and data that are carried out by declaration."""
    library, handlers = run.library.library, run.handlers
    for name, form in library.primitives.items():
        handler = None if name in handlers.results else _handler(run, form)
        if handler is not None:
            run.result_handlers[name] = handler
    data = dict(handlers.data)
    for name, datum in library.data.items():
        handler = None if name in data else _handler(run, datum)
        if handler is not None:
            data[name] = handler
    run.handlers = Handlers(handlers.results, data)


def _handler(
    run: Run, form: nodes.DeclarePrimitive | nodes.DeclareDatum
) -> Callable[..., None] | None:
    """Return the handler for a declaration; None if no effects are complete."""
    effects = named_effects(form, run.library.signatures)
    variables = [arg.variable.name for arg in form.args]

    def carry_out(memory: MemoryAccess, of: Fact, result: str = "") -> None:
        given: dict[Atom, Atom] = dict(zip(variables, of[1:], strict=True))
        for pattern, negated in effects.get(result, ()):
            fact = tuple([given.get(part, part) for part in pattern])
            with _declared(run, of):
                if negated:
                    memory.erase(*fact)
                else:
                    _make_true(memory, fact)

    return carry_out if effects else None


def _make_true(memory: MemoryAccess, fact: Fact) -> None:
    """Assert a fact; the place of an introduced item is set by `move` or `lose`."""
    if fact[0] != "location" or memory.kind(fact[1]) is None:
        memory.assert_fact(*fact)
    elif fact[2] == UNKNOWN:
        memory.lose(str(fact[1]))
    else:
        memory.move(str(fact[1]), fact[2])


@contextmanager
def _declared(run: Run, of: Fact) -> Iterator[None]:
    """Name the world and the result or datum in an error of a change of memory."""
    try:
        yield
    except FactError as error:
        said = f"the changes of memory by {format_list(of)} in the world"
        raise PortError(f"{said} `{run.port.name}`: {error.message}") from error


def apply_changes(
    run: Run, memory: MemoryAccess, of: Fact, changes: Iterable[Change]
) -> None:
    """Apply the changes that a world has sent with a result or datum, in order.

    Args:
        run: the run.
        memory: the memory that a handler gets.
        of: the request or datum, for errors.
        changes: the changes, with items by sensor name.

    Raises:
        PortError: for a change that the declarations do not allow.
    """
    named = run.beliefs.items.named  # all parts but the first
    for change in changes:
        what = str(change[0])
        with _declared(run, of):
            if what == "assert":
                memory.assert_fact(*named(change[1:]))
            elif what == "erase":
                memory.erase(*named(change[1:]))
            elif what == "introduce":
                memory.introduce(str(change[1]), str(change[2]), named(change)[3])
            else:
                getattr(memory, what.replace("-", "_"))(*named(change)[1:])


def changing(
    run: Run, name: str, changes: Sequence[Change], datum: bool = False
) -> Callable[..., Any]:
    """Return a handler that applies changes after the handler of the author, if any.

    Args:
        run: the run.
        name: the name of the primitive or datum.
        changes: the changes.
        datum: whether `name` is a datum.
    """
    handlers = run.port.kit.handlers
    table: Mapping[str, Callable[..., Any]]
    table = handlers.data if datum else handlers.results
    handler = table.get(name)

    def handle(memory: MemoryAccess, of: Fact, *result: str) -> Any:
        told = None if handler is None else handler(memory, of, *result)
        apply_changes(run, memory, of, changes)
        return told

    return handle
