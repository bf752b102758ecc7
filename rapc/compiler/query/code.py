"""The writers of generated code: lines, names, constants, functions.

Nothing of a program's text is ever pasted into generated code: constants are handed to
it, and the names of locals are made here. So formulas of one shape come to the same
text, and that is compiled once.

Not here: what is generated for which formula (`formulas`, `facts`, `term_code`).
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

MAX_LOOPS = 12
"""Loops nested in one function; CPython allows 20 blocks."""

FREE_LOOPS = 2
"""Loops around each other whose turns are not counted: they do at worst as many as the
square of the facts that there are."""

SHAPES = 1024
"""How many shapes of queries a process keeps compiled."""


class ResultMode(Enum):
    """What a generated function returns.

    The two texts are the statement for a solution, and the one without a further
    solution. All that writes code asks for them through `FunctionWriter`
    (`return_solution`, `return_all_of`, `skip`), so a mode that is to say why there is
    no solution needs a row here, its case in `return_all_of`, and in `skip_if` and
    `skip_unless` a line that notes the part and the bindings at which it was given up.
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
    """The code of one variant of a query while it is written: functions and constants.

    Args:
        signatures: the declarations.
        where: the clause's name for faults, with its place in the source.
        later: makes a query of a part of the formula, compiled when it is asked.
    """

    def __init__(
        self,
        signatures: Signatures,
        where: str,
        later: Callable[[nodes.Formula], object],
    ) -> None:
        self.signatures = signatures
        self.later = later
        #: What the code is handed, in order: `k1`, `k2` and so on in its text.
        self.constants: list[object] = []
        #: What the code does, part by part, for a person to read.
        self.steps: list[PlanStep] = []
        #: How many `or` and `not` the next step stands in.
        self.depth = 0
        #: Whether the code counts its steps back: a question may take very many.
        self.counts = False
        #: The functions that several places call, by what they are made for.
        self.shared: dict[object, Any] = {}
        #: The Python locals by variable, in the order in which they came.
        self.locals: dict[str, str] = {}
        self._before: list[str] = []
        self._functions: list[str] = []
        self._made: dict[tuple[object, ...], str] = {}
        self._serial = 0
        #: The constant for the clause's name.
        self.where = self.constant(where)

    def note(self, formula: nodes.Formula, path: AccessPath, **rest: Any) -> None:
        """Note what is done for a part of the formula, before its code is written."""
        self.steps.append(PlanStep(formula, self.depth, path, **rest))

    def fresh(self, prefix: str) -> str:
        """Return a name that nothing else has."""
        return f"{prefix}{self.serial()}"

    def serial(self) -> int:
        """Return a number that nothing else has."""
        self._serial += 1
        return self._serial

    def local(self, variable: str) -> str:
        """Return the local that holds `variable`, the same in all functions."""
        if variable not in self.locals:
            self.locals[variable] = f"v{len(self.locals)}"
        return self.locals[variable]

    def constant(self, value: object) -> str:
        """Return a name under which the code finds `value`."""
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
        """Add the lines of a function that is complete."""
        self._functions.extend(f"    {line}" for line in lines)

    def source(self) -> str:
        """Return the text of `make`, a function that makes `query` for a memory."""
        names = "".join(f"k{n}, " for n in range(1, len(self.constants) + 1))
        taken = [f"    ({names}) = constants"] if names else []
        head = "def make(ctx, constants, aliases, aliased):"
        lines = [head, *taken, *self._before, *self._functions, "    return query"]
        return "\n".join(lines)


Maker = Callable[..., Callable[..., Any]]
"""What `make` of generated code is: it takes a context, the constants, the aliases of
items, and the function to be called in place of `query` while there are any."""


class _Source:
    """A loader as `linecache` asks for one: a traceback shows the generated lines."""

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
    """Return the function `make` that generated source defines; tracebacks show it.

    Args:
        source: the code; no text of a program is in it.
        namespace: the global names that the code uses.
    """
    name = f"generated-query-{zlib.crc32(source.encode()):08x}"
    namespace |= {"__name__": name, "__loader__": _Source(source)}
    exec(compile(source, name, "exec"), namespace)  # noqa: S102  # generated here
    return namespace["make"]


class FunctionWriter:
    """One generated function while it is written."""

    def __init__(
        self, code: CodeWriter, name: str, bound: Iterable[str], mode: ResultMode
    ) -> None:
        #: What all functions of the query share.
        self.code = code
        self.name = name
        self.mode = mode
        #: The constant for the clause's name, and for the query within it.
        self.where = code.where
        #: The variables that it is handed, in order.
        self.parameters = tuple(bound)
        #: Its first lines, unless it is called with its parameters.
        self.head: list[str] = []
        #: Whether it is what is called to ask, and sees to it that the question ends.
        self.is_whole = False
        #: The variables surely bound where the next line comes.
        self.bound: set[str] = set(self.parameters)
        #: Those bound in some branch of an `or` only: a local may hold UNBOUND.
        self.maybe: set[str] = set()
        #: How many loops the next line stands in.
        self.loops = 0
        #: How many loops the call of the function stands in.
        self.outer = 0
        self._indent = 1
        self._lines: list[str] = []
        self._loop_indents: list[int] = []
        self._renamed: dict[str, str] = {}

    @property
    def known(self) -> list[str]:
        """The variables that are or may be bound, in the order in which they came."""
        return [name for name in self.code.locals if name in self.bound | self.maybe]

    def local(self, variable: str) -> str:
        """Return the Python local that holds `variable` here."""
        return self._renamed.get(variable) or self.code.local(variable)

    def rename(self, variable: str) -> str:
        """Return a new local for `variable` from here on.

        A variable that may be bound keeps its old local untouched, so that the next
        candidate of a loop finds it as it was.
        """
        self._renamed[variable] = self.code.fresh("v_")
        return self._renamed[variable]

    def child(
        self, prefix: str, needed: Iterable[str], mode: ResultMode
    ) -> FunctionWriter:
        """Begin another function, handed the `needed` variables as far as known."""
        known = self.bound | self.maybe
        inner = FunctionWriter(
            self.code,
            self.code.fresh(prefix),
            [name for name in dict.fromkeys(needed) if name in known],
            mode,
        )
        inner.where = self.where
        inner.outer = self.outer + self.loops
        inner.maybe = self.maybe & inner.bound
        inner.bound -= inner.maybe
        return inner

    def line(self, text: str) -> None:
        """Add a line at the present depth."""
        self._lines.append("    " * self._indent + text)

    def loop(self, head: str) -> None:
        """Open a loop; all that follows is inside it."""
        self.line(head)
        self._loop_indents.append(self._indent)
        self._indent += 1
        self.loops += 1

    @property
    def skip(self) -> str:
        """The statement that gives up the candidate at hand."""
        return "continue" if self.loops else self.mode.value[1]

    def skip_unless(self, condition: str) -> None:
        """Give up the candidate unless `condition` holds."""
        self.line(f"if not ({condition}): {self.skip}")

    def skip_if(self, condition: str) -> None:
        """Give up the candidate if `condition` holds."""
        self.line(f"if {condition}: {self.skip}")

    def call(self, inner: FunctionWriter) -> str:
        """Return the expression that calls another function from here."""
        return f"{inner.name}({', '.join(self.local(p) for p in inner.parameters)})"

    def return_solution(self, solution: str) -> None:
        """Write the statement for a solution, in the function's result mode."""
        self.line(self.mode.value[0].format(solution))

    def return_all_of(self, call: str) -> None:
        """Return every solution of `call`, a function of the same result mode."""
        if self.mode is ResultMode.EACH:
            self.line(f"yield from {call}")
        elif self.mode is ResultMode.ANY:
            self.line(f"if {call}: return True")
        elif self.mode is ResultMode.ALL:
            self.line(f"found.extend({call})")
        else:
            answer = self.code.fresh("t")
            self.line(f"{answer} = {call}")
            self.line(f"if {answer} is not None: return {answer}")

    def values(self, exports: Iterable[str]) -> str:
        """Return the expression for a tuple of the values of `exports`."""
        return f"({''.join(f'{self.local(name)}, ' for name in exports)})"

    def close(self) -> None:
        """Add the function to the code."""
        names = ", ".join(self.code.local(p) for p in self.parameters)
        opened = self.head or [f"def {self.name}({names}):"]
        if self.mode is ResultMode.ALL:
            opened = [*opened, "    found = []"]
        self._count()
        body = [*self._lines, f"    {self.mode.value[1]}"]
        if self.is_whole and self.code.counts:
            body = self._bounded(body)
        self.code.add([*opened, *body])

    def _count(self) -> None:
        """Count a step back behind each loop that stands deep inside of others.

        What is written here is reached where the loop has found nothing, so a question
        that has its answer at once pays nothing for it.
        """
        for depth in range(self.loops, 0, -1):
            if self.outer + depth > FREE_LOOPS:
                self.code.counts = True
                margin = "    " * self._loop_indents[depth - 1]
                self._lines.append(f"{margin}ctx.steps_left -= 1")
                self._lines.append(f"{margin}if ctx.steps_left < 0: raise TooManySteps")

    def _bounded(self, body: Iterable[str]) -> list[str]:
        """Return the lines of a whole question so that they end within its bound."""
        return [
            "    ctx.steps_left = ctx.most_steps",
            "    try:",
            *(f"    {line}" for line in body),
            "    except TooManySteps:",
            f"        ctx.give_up({self.code.where})",
            f"        return{_NOTHING[self.mode]}",
        ]


_NOTHING = {
    ResultMode.EACH: "",
    ResultMode.FIRST: " None",
    ResultMode.ANY: " False",
    ResultMode.ALL: " []",
}
"""What a question returns that has no answer."""
