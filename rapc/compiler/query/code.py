"""The writer of generated code: names, constants, functions, compilation.

No text of a program is inserted into generated code: constants are passed as arguments,
and the names of locals are generated. So formulas of equal shape have equal generated
text, which is compiled once.

Not here: the lines of one function (`function`), and the code for each kind of formula
(`formulas`, `facts`, `term_code`).
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from enum import Enum
from functools import lru_cache
from typing import Any

from rapc.compiler.query import builtin
from rapc.compiler.query.plan_steps import AccessPath, PlanStep
from rapc.ir import nodes
from rapc.library.signatures import Signatures

SHAPES = 1024
"""The number of query shapes in the cache of compiled code."""


class ResultMode(Enum):
    """The kind of result of a generated function.

    The two texts are the statement for a solution, and the statement for no further
    solution. All writers of code obtain the texts through `FunctionWriter`
    (`return_solution`, `return_all_of`, `skip`). A new mode, for example to report why
    there is no solution, needs a row here, its case in `return_all_of`, and in
    `skip_if` and `skip_unless` a line that records the part and the bindings of the
    failure.
    """

    #: An iterator over the solutions.
    EACH = ("yield {}", "return")
    #: The first solution, or None.
    FIRST = ("return {}", "return None")
    #: Whether there is a solution.
    ANY = ("return True", "return False")
    #: A list of the solutions.
    ALL = ("found.append({})", "return found")


class CodeWriter:
    """The unfinished code of one variant of a query: functions and constants.

    Args:
        signatures: the declarations.
        where: the clause's name for faults, with its position in the source.
        later: returns a query for a part of the formula, compiled at its first use.
    """

    def __init__(
        self,
        signatures: Signatures,
        where: str,
        later: Callable[[nodes.Formula], object],
    ) -> None:
        self.signatures = signatures
        self.later = later
        #: The arguments of the code, in order: `k1`, `k2` and so on in its text.
        self.constants: list[object] = []
        #: The steps of the code, part by part, for explanations.
        self.steps: list[PlanStep] = []
        #: The number of `or` and `not` around the next step.
        self.depth = 0
        #: Whether the code counts its steps back: a query may need very many.
        self.counts = False
        #: The shared functions, by the part that each solves.
        self.shared: dict[object, Any] = {}
        #: The Python locals by variable, in the order of their creation.
        self.locals: dict[str, str] = {}
        self._before: list[str] = []
        self._functions: list[str] = []
        self._made: dict[tuple[object, ...], str] = {}
        self._serial = 0
        #: The clause's name, and the constant for it.
        self.clause = where
        self.where = self.constant(where)
        self._places = {"": self.where}

    def note(self, formula: nodes.Formula, path: AccessPath, **rest: Any) -> None:
        """Record the step for a part of the formula, before its code is written."""
        self.steps.append(PlanStep(formula, self.depth, path, **rest))

    def fresh(self, prefix: str) -> str:
        """Return an unused name."""
        return f"{prefix}{self.serial()}"

    def serial(self) -> int:
        """Return an unused number."""
        self._serial += 1
        return self._serial

    def local(self, variable: str) -> str:
        """Return the local that holds `variable`, the same in all functions."""
        if variable not in self.locals:
            self.locals[variable] = f"v{len(self.locals)}"
        return self.locals[variable]

    def place(self, within: str) -> str:
        """Return a constant for the clause's name with the names of outer queries."""
        if within not in self._places:
            self._places[within] = self.constant(within + self.clause)
        return self._places[within]

    def constant(self, value: object) -> str:
        """Return the name of `value` in the code."""
        self.constants.append(value)
        return f"k{len(self.constants)}"

    def stamps(self, name: str) -> str:
        """Return a name for the stamps of all facts called `name`."""
        return self._once(("stamps", name), f"{self._table(name)}.stamps")

    def value_of(self, name: str) -> str:
        """Return a name for the look-up of a property's fact by its index."""
        return self._once(("values", name), f"{self._table(name)}.values.get")

    def bucket_of(self, name: str, at: int) -> str:
        """Return a name for the look-up of facts by their argument number `at`."""
        return self._once(("index", name, at), f"{self._table(name)}.index({at}).get")

    def _table(self, name: str) -> str:
        known = self._made.get(("table", name))
        if known is not None:
            return known
        table = f"ctx.facts.table({self.constant(name)})"
        return self._once(("table", name), table)

    def _once(self, key: tuple[object, ...], expression: str) -> str:
        """Return a local for `expression`, evaluated once when a query is bound."""
        name = self._made.get(key)
        if name is None:
            name = self._made[key] = self.fresh("m")
            self._before.append(f"    {name} = {expression}")
        return name

    def add(self, lines: Iterable[str]) -> None:
        """Add the lines of a complete function."""
        self._functions.extend(f"    {line}" for line in lines)

    def source(self) -> str:
        """Return the text of `make`, a function that makes `query` for a memory."""
        names = "".join(f"k{n}, " for n in range(1, len(self.constants) + 1))
        taken = [f"    ({names}) = constants"] if names else []
        head = "def make(ctx, constants, aliases, aliased):"
        lines = [head, *taken, *self._before, *self._functions, "    return query"]
        return "\n".join(lines)


Maker = Callable[..., Callable[..., Any]]
"""The type of `make` in generated code.

Its arguments are a context, the constants, the aliases of items, and the function that
replaces `query` while there are aliases.
"""


class _Source:
    """A loader for `linecache`: a traceback shows the generated lines."""

    __slots__ = ("_source",)

    def __init__(self, source: str) -> None:
        self._source = source

    def get_source(self, name: str) -> str:
        """Return the generated text."""
        return self._source


@lru_cache(maxsize=SHAPES)
def compile_source(source: str) -> Maker:
    """Compile generated source and return its `make` function; cached by source."""
    namespace: dict[str, Any] = {
        "UNBOUND": builtin.UNBOUND,
        "QueryFault": builtin.QueryFault,
        "TooManySteps": builtin.TooManySteps,
        "as_value": builtin.as_value,
        "holds": builtin.holds,
        "set_members": builtin.set_members,
        "NUMBERS": (int, float),
    }
    maker: Maker = made_of(source, namespace)
    return maker


def made_of(source: str, namespace: dict[str, Any]) -> Any:
    """Return the function `make` of generated source; tracebacks show the source.

    Args:
        source: the code; no text of a program is in it.
        namespace: the global names that the code uses.
    """
    name = f"generated-query-{zlib.crc32(source.encode()):08x}"
    namespace |= {"__name__": name, "__loader__": _Source(source)}
    exec(compile(source, name, "exec"), namespace)  # noqa: S102  # generated here
    return namespace["make"]
