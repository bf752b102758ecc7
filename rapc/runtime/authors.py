"""The Python code of a world and a host, and its numbers of arguments.

The number of arguments is checked before a run begins. Not here: errors of the code in
a run (`held_world`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from inspect import signature
from types import FunctionType, MethodType

from rapc.base.code_places import place_of
from rapc.base.names import plural
from rapc.world import Kit

Named = Mapping[str, Callable[..., object]]
"""Python callables by the names that a library uses."""

_GIVEN = {
    "the handler of": ("memory", "request", "result"),
    "the handler of the datum": ("memory", "datum"),
    "the solver of": ("goal", "memory"),
    "the comparator": ("one", "other"),
}
"""The arguments of a call, by the kind of callable."""

_VARIADIC = 0x04
"""The flag of a function with `*args`."""


def code_of_authors(
    kit: Kit,
    functions: Named | None = None,
    solvers: Named | None = None,
    comparators: Named | None = None,
) -> dict[str, Named]:
    """Return all Python code of authors by its kind in messages, then by name.

    The last three arguments are the host's code, which replaces code of the world with
    the same name.
    """
    return {
        "the handler of": kit.handlers.results,
        "the handler of the datum": kit.handlers.data,
        "the function": {**kit.functions, **(functions or {})},
        "the solver of": {**kit.solvers, **(solvers or {})},
        "the comparator": {**kit.comparators, **(comparators or {})},
    }


def wrong_arities(what: str, code: Named, given: int) -> Iterator[str]:
    """Yield a line for each callable that does not take the `given` arguments.

    Args:
        what: the kind of the callables in messages: `the solver`.
        code: the callables by name.
        given: the number of arguments of each call.
    """
    for name, call in code.items():
        if not callable(call):
            yield f"{what} `{name}` is no function"
        elif not takes(call, given):
            count = plural(given, "argument")
            named = f" ({', '.join(_GIVEN[what])})" if what in _GIVEN else ""
            yield f"{what} `{name}`{place_of(call)} is called with {count}{named}"


def takes(call: Callable[..., object], given: int) -> bool:
    """Return whether `call` may be called with `given` arguments.

    True if Python cannot inspect the callable, as for some built-in functions.
    """
    if isinstance(call, MethodType):
        return takes(call.__func__, given + 1)
    if not isinstance(call, FunctionType):
        try:
            signature(call).bind(*range(given))
        except TypeError:
            return False
        except ValueError:
            return True
        return True
    code = call.__code__
    required = code.co_argcount - len(call.__defaults__ or ())
    named = code.co_kwonlyargcount - len(call.__kwdefaults__ or ())
    most = given if code.co_flags & _VARIADIC else code.co_argcount
    return required <= given <= most and not named
