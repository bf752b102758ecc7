"""The little that generated code needs: lines, names, constants, sub-generators.

What is generated for which formula is decided in `rapc.compiler.formulas`. Nothing of
a program's text is ever pasted into generated code: constants travel in the
namespace, and the names of locals are made here.
"""

from __future__ import annotations

from collections.abc import Iterable

MAX_LOOPS = 12
"""Loops nested in one function; CPython allows 20 blocks."""


class Emitter:
    """Collects the functions of one compiled query."""

    def __init__(self) -> None:
        self.namespace: dict[str, object] = {}
        self.functions: list[str] = []
        self._locals: dict[str, str] = {}
        self._serial = 0

    def fresh(self, prefix: str) -> str:
        """A name that nothing else has."""
        self._serial += 1
        return f"{prefix}{self._serial}"

    def local(self, variable: str) -> str:
        """The Python local that holds a variable, the same in all functions."""
        if variable not in self._locals:
            self._locals[variable] = f"v{len(self._locals)}"
        return self._locals[variable]

    def constant(self, value: object) -> str:
        """A name under which generated code finds a value."""
        name = self.fresh("k")
        self.namespace[name] = value
        return name


class Scope:
    """One generated function while it is being written.

    `bound` are the variables surely bound here, `maybe` those bound in some branch
    of an `or` only (their locals may hold UNBOUND).
    """

    def __init__(self, emitter: Emitter, name: str, bound: Iterable[str]) -> None:
        self.emitter = emitter
        self.name = name
        self.parameters = tuple(bound)
        self.bound: set[str] = set(self.parameters)
        self.maybe: set[str] = set()
        self.loops = 0
        self._indent = 1
        self._lines: list[str] = []
        self._renamed: dict[str, str] = {}

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

    def child(self, prefix: str, needed: Iterable[str]) -> Scope:
        """A function of its own that is handed the variables it needs."""
        known = self.bound | self.maybe
        inner = Scope(
            self.emitter,
            self.emitter.fresh(prefix),
            [name for name in dict.fromkeys(needed) if name in known],
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
        return "continue" if self.loops else "return"

    def require(self, condition: str) -> None:
        """Give up unless a condition holds."""
        self.line(f"if not ({condition}): {self.skip}")

    def refuse(self, condition: str) -> None:
        """Give up if a condition holds."""
        self.line(f"if {condition}: {self.skip}")

    def call(self, inner: Scope) -> str:
        """The expression that starts another function as a generator from here."""
        names = "".join(f", {self.local(p)}" for p in inner.parameters)
        return f"{inner.name}(ctx{names})"

    def finish(self, exports: Iterable[str]) -> None:
        """End with the solution: a tuple of the exported variables' values."""
        names = [self.local(n) for n in exports]
        self.line(f"yield ({''.join(n + ', ' for n in names)})")

    def close(self) -> None:
        """Hand the function's source to the emitter."""
        names = "".join(f", {self.emitter.local(p)}" for p in self.parameters)
        head = [
            f"def {self.name}(ctx{names}):",
            "    values = ctx.values",
            "    buckets = ctx.buckets",
        ]
        self.emitter.functions.append("\n".join([*head, *self._lines]))
