"""The reference of Python modules, made from docstrings and comments."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Callable
from importlib import import_module
from itertools import pairwise, takewhile
from types import ModuleType
from typing import Any

from generator.markdown import block, code, table


class Notes(dict[str, str]):
    """The comments and docstrings of the fields or names in a class or module."""

    @classmethod
    def of(cls, owner: type | ModuleType) -> Notes:
        """Return the notes of a class, with its constructor, or of a module."""
        text = inspect.cleandoc("\n" + inspect.getsource(owner))
        lines, body = text.splitlines(), ast.parse(text).body
        bodies = [body]
        if isinstance(owner, type) and isinstance(body[0], ast.ClassDef):
            made = [s for s in body[0].body if isinstance(s, ast.FunctionDef)]
            bodies = [body[0].body, *(s.body for s in made if s.name == "__init__")]
        found = cls()
        for statements in bodies:
            for one, after in pairwise([*statements, ast.Pass()]):
                if name := _assigned(one):
                    note = _above(lines[: one.lineno - 1]) or _below(after)
                    found[name] = note or found.get(name, "")
        return found


def _above(lines: list[str]) -> str:
    """Return the comment of the kind `#:` at the end of some lines."""
    stripped = [line.strip() for line in reversed(lines)]
    said = takewhile(lambda line: line.startswith("#:"), stripped)
    return " ".join(line[2:].strip() for line in [*said][::-1])


def _below(after: ast.stmt) -> str:
    """Return the docstring after an assignment."""
    if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
        return str(after.value.value)
    return ""


def _assigned(statement: ast.stmt) -> str | None:
    """Return the name of the field or the attribute that a statement assigns."""
    if isinstance(statement, ast.AnnAssign):
        target: ast.expr = statement.target
    elif isinstance(statement, ast.Assign):
        target = statement.targets[0]
    else:
        return None
    if isinstance(target, ast.Attribute):
        return target.attr
    return target.id if isinstance(target, ast.Name) else None


_REFERENCE = re.compile(r" ?\[[TSL] [^\]]*\]")
"""A reference to a source: `[T 3.3]`."""

_PART = re.compile(r"^(Args|Attributes|Returns|Yields|Raises):$", re.M)


def api(module: str, *names: str) -> str:
    """Return the reference of some public names of a module, or of all names."""
    home = import_module(module)
    public = [name for name in home.__all__ if name != "__version__"]
    public.sort(key=lambda name: _order(getattr(home, name)))
    return "\n".join(filter(None, [_name(home, name) for name in names or public]))


def _order(found: object) -> int:
    """Return the position of functions, classes, errors and other names."""
    if isinstance(found, type):
        return 2 if issubclass(found, Exception) else 1
    return 0 if inspect.isfunction(found) else 3


def _name(home: ModuleType, name: str) -> str:
    found = getattr(home, name)
    if isinstance(found, ModuleType):
        return ""
    title = f"### {name}\n\n"
    if not isinstance(found, type):
        return title + (
            _function(name, found) if inspect.isfunction(found) else _value(home, name)
        )
    if found.__module__ == "builtins" or not found.__module__.startswith("rapc"):
        return title + _value(home, name)
    if found.__name__ != name:
        return title + _value(home, name)
    return title + _class(found)


def _value(home: ModuleType, name: str) -> str:
    """Return the note of a name that is no function and no class."""
    for statement in ast.parse(inspect.getsource(home)).body:
        if isinstance(statement, ast.ImportFrom) and any(
            alias.name == name for alias in statement.names
        ):
            home = import_module(str(statement.module))
    return f"{plain(Notes.of(home).get(name, ''))}\n"


def _class(found: type) -> str:
    parts = [_doc(inspect.cleandoc(found.__doc__ or ""))]
    notes = Notes.of(found)
    fields = getattr(found, "__struct_fields__", notes)
    structured = hasattr(found, "__struct_fields__")
    types = getattr(found, "__annotations__", {})
    rows = [
        (f"`{name}`", code(types.get(name, "")), plain(notes.get(name, "")))
        for name in fields
        if name[0] != "_" and (structured or notes[name])
    ]
    base = issubclass(found, BaseException)
    if rows and not base:
        parts.append(table(("field", "type", "meaning"), rows))
    for name, own in vars(found).items():
        member = own.__func__ if isinstance(own, classmethod) else own
        if name.startswith("_") or not getattr(member, "__doc__", None):
            continue
        if inspect.isfunction(member):
            parts.append(f"#### {found.__name__}.{name}\n\n{_function(name, member)}")
        elif isinstance(member, property):
            text = _doc(inspect.cleandoc(member.__doc__ or ""))
            parts.append(f"#### {found.__name__}.{name}\n\n{text}")
    return "\n".join(filter(None, parts))


class _Annotation(str):
    """An annotation that a signature shows without quotes."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def _function(name: str, function: Callable[..., Any]) -> str:
    signature = inspect.signature(function)
    parameters = [
        parameter.replace(annotation=_annotation(parameter.annotation))
        for parameter in signature.parameters.values()
        if parameter.name not in ("self", "cls")
    ]
    returned = _annotation(signature.return_annotation)
    signature = signature.replace(parameters=parameters, return_annotation=returned)
    text = block("py", _folded(name, str(signature)))
    return f"{text}\n{_doc(inspect.cleandoc(function.__doc__ or ''))}"


def _annotation(found: object) -> object:
    return _Annotation(found) if isinstance(found, str) else found


def _folded(name: str, signature: str, width: int = 76) -> str:
    """Return a signature with a line for each parameter if it is long."""
    if len(name + signature) <= width:
        return name + signature
    inside, _, result = signature[1:].rpartition(")")
    depth = 0
    lines = [""]
    for letter in inside:
        depth += {"[": 1, "(": 1, "]": -1, ")": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            lines.append("")
        else:
            lines[-1] += letter
    return f"{name}(\n" + "".join(f"    {p.strip()},\n" for p in lines) + f"){result}"


def _doc(text: str) -> str:
    """Return a docstring as Markdown: its parts as lists."""
    before, *parts = _PART.split(plain(text))
    found = [before.strip()]
    for title, part in zip(parts[::2], parts[1::2], strict=True):
        body, _, after = inspect.cleandoc(f"\n{part}").partition("\n\n")
        entries = [" ".join(e.split()) for e in re.split(r"\n(?=\S)", body)]
        items = [re.sub(r"^([\w*]+): ", r"`\1`: ", entry) for entry in entries if entry]
        found.append(f"{title}:\n\n" + "\n".join(f"- {item}" for item in items))
        if after:
            found.append(after)
    return "\n\n".join(filter(None, found)) + "\n"


def plain(text: str) -> str:
    """Return a text without references to sources."""
    return _REFERENCE.sub("", text)
