"""The writer of one generated function: loops, rejected candidates, steps back.

Not here: the shared parts of the functions of a query, and compilation (`code`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rapc.compiler.query.code import CodeWriter, ResultMode
from rapc.ir import nodes

MAX_LOOPS = 12
"""The highest number of nested loops in a function; CPython allows 20 blocks."""

FREE_SEARCHES = 2
"""The number of preceding searching parts from which steps back count [L 2.70].

Fewer parts visit at most the square of the number of facts.
"""


class FunctionWriter:
    """One unfinished generated function."""

    def __init__(
        self, code: CodeWriter, name: str, bound: Iterable[str], mode: ResultMode
    ) -> None:
        #: The shared parts of all functions of the query.
        self.code = code
        self.name = name
        self.mode = mode
        #: The names of the outer queries for faults, up to those that are passed in.
        self.within = ""
        #: Whether the names of the clause and the outer queries are passed in.
        self.is_shared = False
        #: The variables that are passed in, in order.
        self.parameters = tuple(bound)
        for variable in self.parameters:
            code.local(variable)
        #: Its first lines, unless the writer derives them from its parameters.
        self.head: list[str] = []
        #: Whether it is the entry of the query, which enforces the limit of steps back.
        self.is_whole = False
        #: The variables that are certainly bound at the next line.
        self.bound: set[str] = set(self.parameters)
        #: The variables bound in only some branches of an `or`: a local may hold
        #: UNBOUND.
        self.maybe: set[str] = set()
        #: The number of loops around the next line.
        self.loops = 0
        #: The variables with a value there, by the text [L 2.71].
        self.given: set[str] = set(self.parameters)
        #: The number of searching parts before the next line, in this function.
        self.searches = 0
        #: The number of searching parts before the call, at most the number of free
        #: parts.
        self.outer = 0
        self._indent = 1
        self._lines: list[str] = []
        self._counted: list[int] = []
        self._renamed: dict[str, str] = {}

    @property
    def known(self) -> list[str]:
        """Return the variables that are or may be bound, in the order of binding."""
        return [name for name in self.code.locals if name in self.bound | self.maybe]

    def local(self, variable: str) -> str:
        """Return the Python local that holds `variable` here."""
        return self._renamed.get(variable) or self.code.local(variable)

    def rename(self, variable: str) -> str:
        """Return a new local for `variable` from here on.

        A variable that may be bound keeps its old local unchanged, for the next
        candidate of a loop.
        """
        self._renamed[variable] = self.code.fresh("v_")
        return self._renamed[variable]

    def child(
        self, prefix: str, needed: Iterable[str], mode: ResultMode
    ) -> FunctionWriter:
        """Begin another function; pass the `needed` variables if they are known."""
        known = self.bound | self.maybe
        inner = FunctionWriter(
            self.code,
            self.code.fresh(prefix),
            [name for name in dict.fromkeys(needed) if name in known],
            mode,
        )
        inner.within, inner.is_shared = self.within, self.is_shared
        inner.outer = min(self.outer + self.searches, FREE_SEARCHES)
        inner.given = set(self.given)
        inner.maybe = self.maybe & inner.bound
        inner.bound -= inner.maybe
        return inner

    def line(self, text: str) -> None:
        """Add a line at the present depth."""
        self._lines.append("    " * self._indent + text)

    def loop(self, head: str) -> None:
        """Open a loop around all later lines."""
        self.line(head)
        self._indent += 1
        self.loops += 1

    def search(self, head: str) -> None:
        """Open the loop of a searching part; the end of the loop is a step back."""
        if self.is_deep:
            self._counted.append(self._indent)
        self.loop(head)
        self.searches += 1

    @property
    def is_deep(self) -> bool:
        """Return whether the steps back of a searching part at this line count."""
        return self.outer + self.searches >= FREE_SEARCHES

    def is_open(self, term: nodes.Term) -> bool:
        """Return whether a term is a variable that by the text may lack a value."""
        return isinstance(term, nodes.Var) and (
            term.anonymous or term.name not in self.given
        )

    def step_back(self, indent: int | None = None) -> None:
        """Write the count of a step back, at the present or a given depth."""
        self.code.counts = True
        margin = "    " * (self._indent if indent is None else indent)
        self._lines.append(f"{margin}ctx.steps_left -= 1")
        self._lines.append(f"{margin}if ctx.steps_left < 0: raise TooManySteps")

    @property
    def skip(self) -> str:
        """Return the statement that rejects the present candidate."""
        return "continue" if self.loops else self.mode.value[1]

    def skip_unless(self, condition: str) -> None:
        """Reject the candidate unless `condition` holds."""
        self.line(f"if not ({condition}): {self.skip}")

    def skip_if(self, condition: str) -> None:
        """Reject the candidate if `condition` holds."""
        self.line(f"if {condition}: {self.skip}")

    @property
    def where(self) -> str:
        """Return the expression for the names of the clause and the outer queries."""
        if not self.is_shared:
            return self.code.place(self.within)
        return f"{self.code.constant(self.within)} + where" if self.within else "where"

    def call(self, inner: FunctionWriter) -> str:
        """Return the expression that calls another function from here."""
        taken = [self.local(p) for p in inner.parameters]
        return f"{inner.name}({', '.join(inner.place_and(taken))})"

    def place_and(self, names: Sequence[str]) -> list[str]:
        """Return parameters, after the parameter for the clause's name, if any."""
        return [*(["where"] if self.is_shared else []), *names]

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
        names = self.place_and([self.code.local(p) for p in self.parameters])
        opened = self.head or [f"def {self.name}({', '.join(names)}):"]
        if self.mode is ResultMode.ALL:
            opened = [*opened, "    found = []"]
        self._count()
        body = [*self._lines, f"    {self.mode.value[1]}"]
        if self.is_whole and self.code.counts:
            body = self._bounded(body)
        self.code.add([*opened, *body])

    def _count(self) -> None:
        """Count a step back after the loop of each deep part.

        The counting code runs only when the loop finds no solution, so a query with an
        immediate solution has no cost.
        """
        for indent in reversed(self._counted):
            self.step_back(indent)

    def _bounded(self, body: Iterable[str]) -> list[str]:
        """Return the lines of a whole query with the limit of its steps back."""
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
"""The result of a query without a solution."""
