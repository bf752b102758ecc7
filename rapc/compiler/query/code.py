"""The little that generated code needs: lines, names, constants, sub-functions.

What is generated for which formula is decided in `rapc.compiler.query.formulas`.
Nothing of a program's text is ever pasted into generated code: constants are handed
to it, and
the names of locals are made here. So formulas of one shape come to the same text,
and that is compiled once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import Enum
from functools import lru_cache
from typing import Any

from rapc.compiler.query import builtin
from rapc.compiler.query.plan_steps import Step

MAX_LOOPS = 12
"""Loops nested in one function; CPython allows 20 blocks."""

SHAPES = 1024
"""How many shapes of queries a process keeps compiled."""


class Ending(Enum):
    """What a generated function does with a solution, and without a further one."""

    EACH = ("yield {}", "return")
    FIRST = ("return {}", "return None")
    ANY = ("return True", "return False")
    ALL = ("found.append({})", "return found")


class Emitter:
    """Collects the functions of one compiled query, and what they are handed.

    `steps` tells what they do, for a person; `depth` is that of the step to come.
    `locals` holds the Python locals by variable, in the order in which they came.
    """

    def __init__(self) -> None:
        self.constants: list[object] = []
        self.steps: list[Step] = []
        self.depth = 0
        self._before: list[str] = []
        self._functions: list[str] = []
        self.locals: dict[str, str] = {}
        self._made: dict[tuple[object, ...], str] = {}
        self._serial = 0

    def fresh(self, prefix: str) -> str:
        """A name that nothing else has."""
        self._serial += 1
        return f"{prefix}{self._serial}"

    def local(self, variable: str) -> str:
        """The Python local that holds a variable, the same in all functions."""
        if variable not in self.locals:
            self.locals[variable] = f"v{len(self.locals)}"
        return self.locals[variable]

    def constant(self, value: object) -> str:
        """A name under which generated code finds a value."""
        self.constants.append(value)
        return f"k{len(self.constants)}"

    def stamps(self, name: str) -> str:
        """A name for the stamps of all facts of a name."""
        return self._once(("stamps", name), f"{self._table(name)}.stamps")

    def value_of(self, name: str) -> str:
        """A name for the look-up of a property's fact by its index."""
        return self._once(("values", name), f"{self._table(name)}.values.get")

    def bucket_of(self, name: str, at: int) -> str:
        """A name for the look-up of facts by one of their arguments."""
        return self._once(("index", name, at), f"{self._table(name)}.index({at}).get")

    def _table(self, name: str) -> str:
        known = self._made.get(("table", name))
        if known is not None:
            return known
        table = f"ctx.facts.table({self.constant(name)})"
        return self._once(("table", name), table)

    def _once(self, key: tuple[object, ...], expression: str) -> str:
        """A name for what an expression comes to when a query meets its memory."""
        name = self._made.get(key)
        if name is None:
            name = self._made[key] = self.fresh("m")
            self._before.append(f"    {name} = {expression}")
        return name

    def add(self, lines: Iterable[str]) -> None:
        """A function is complete."""
        self._functions.extend(f"    {line}" for line in lines)

    def source(self) -> str:
        """The text of a function that makes `query` for a context and constants."""
        names = "".join(f"k{n}, " for n in range(1, len(self.constants) + 1))
        taken = [f"    ({names}) = constants"] if names else []
        head = "def make(ctx, constants, aliases, aliased):"
        lines = [head, *taken, *self._before, *self._functions, "    return query"]
        return "\n".join(lines)


Maker = Callable[..., Callable[..., Any]]
"""Makes a query's function: of a context, the constants, aliases, who sees to them."""


@lru_cache(maxsize=SHAPES)
def made(source: str) -> Maker:
    """What a text from `Emitter.source` defines; the same for the same text."""
    namespace: dict[str, Any] = {
        "UNBOUND": builtin.UNBOUND,
        "Fault": builtin.Fault,
        "as_value": builtin.as_value,
        "holds": builtin.holds,
        "set_members": builtin.set_members,
        "NUMBERS": (int, float),
    }
    code = compile(source, "<query>", "exec")
    exec(code, namespace)  # noqa: S102  # generated here; no program text is in it
    maker: Maker = namespace["make"]
    return maker


class Scope:
    """One generated function while it is being written.

    `bound` are the variables surely bound here, `maybe` those bound in some branch
    of an `or` only (their locals may hold UNBOUND). `head` are its first lines, where
    they are not those of a function that is called with its parameters.
    """

    def __init__(
        self, emitter: Emitter, name: str, bound: Iterable[str], ending: Ending
    ) -> None:
        self.emitter = emitter
        self.name = name
        self.ending = ending
        self.parameters = tuple(bound)
        self.head: list[str] = []
        self.bound: set[str] = set(self.parameters)
        self.maybe: set[str] = set()
        self.loops = 0
        self._indent = 1
        self._lines: list[str] = []
        self._renamed: dict[str, str] = {}

    @property
    def known(self) -> list[str]:
        """The variables that are or may be bound, in the order in which they came."""
        return [name for name in self.emitter.locals if name in self.bound | self.maybe]

    def local(self, variable: str) -> str:
        """The Python local that holds a variable here."""
        return self._renamed.get(variable) or self.emitter.local(variable)

    def rename(self, variable: str) -> str:
        """A new local for a variable from here on.

        A variable that may be bound keeps its old local untouched, so that the next
        candidate of a loop finds it as it was.
        """
        self._renamed[variable] = self.emitter.fresh("v_")
        return self._renamed[variable]

    def child(self, prefix: str, needed: Iterable[str], ending: Ending) -> Scope:
        """A function of its own that is handed the variables it needs."""
        known = self.bound | self.maybe
        inner = Scope(
            self.emitter,
            self.emitter.fresh(prefix),
            [name for name in dict.fromkeys(needed) if name in known],
            ending,
        )
        inner.maybe = self.maybe & inner.bound
        inner.bound -= inner.maybe
        return inner

    def line(self, text: str) -> None:
        """Add a line at the present depth."""
        self._lines.append("    " * self._indent + text)

    def loop(self, head: str) -> None:
        """Open a loop; all that follows is inside it."""
        self.line(head)
        self._indent += 1
        self.loops += 1

    @property
    def skip(self) -> str:
        """The statement that gives up the present candidate."""
        return "continue" if self.loops else self.ending.value[1]

    def require(self, condition: str) -> None:
        """Give up unless a condition holds."""
        self.line(f"if not ({condition}): {self.skip}")

    def refuse(self, condition: str) -> None:
        """Give up if a condition holds."""
        self.line(f"if {condition}: {self.skip}")

    def call(self, inner: Scope) -> str:
        """The expression that calls another function from here."""
        return f"{inner.name}({', '.join(self.local(p) for p in inner.parameters)})"

    def finish(self, solution: str) -> None:
        """End with a solution, given as an expression."""
        self.line(self.ending.value[0].format(solution))

    def hand_on(self, call: str) -> None:
        """End with the solutions that another function of the same ending finds."""
        if self.ending is Ending.EACH:
            self.line(f"yield from {call}")
        elif self.ending is Ending.ANY:
            self.line(f"if {call}: return True")
        elif self.ending is Ending.ALL:
            self.line(f"found.extend({call})")
        else:
            answer = self.emitter.fresh("t")
            self.line(f"{answer} = {call}")
            self.line(f"if {answer} is not None: return {answer}")

    def values(self, exports: Iterable[str]) -> str:
        """The expression for a tuple of the values of variables."""
        return f"({''.join(f'{self.local(name)}, ' for name in exports)})"

    def close(self) -> None:
        """Hand the function's source to the emitter."""
        names = ", ".join(self.emitter.local(p) for p in self.parameters)
        opened = self.head or [f"def {self.name}({names}):"]
        if self.ending is Ending.ALL:
            opened = [*opened, "    found = []"]
        self.emitter.add([*opened, *self._lines, f"    {self.ending.value[1]}"])
