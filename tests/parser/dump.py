"""IR as stable text for golden files: a line per field, without spans."""

from __future__ import annotations

from typing import Any

from rapc.base.source import Span
from rapc.base.values import format_atom
from rapc.ir.nodes import Node


def dump(node: Node) -> str:
    """A node as indented text that ends with a line end.

    Fields that are None or empty, and spans, are left out.
    """
    return "\n".join(_lines(node, "")) + "\n"


def _lines(value: Any, indent: str) -> list[str]:
    deeper = indent + "  "
    if isinstance(value, Node):
        lines = [f"{indent}{type(value).__name__}"]
        for name in value.__struct_fields__:
            field = getattr(value, name)
            if field is None or isinstance(field, Span) or field in ((), ""):
                continue
            if isinstance(field, Node | tuple):
                lines += [f"{deeper}{name}:", *_lines(field, deeper + "  ")]
            else:
                lines.append(f"{deeper}{name}: {_scalar(field)}")
        return lines
    if isinstance(value, tuple):
        return [line for item in value for line in _lines(item, indent)]
    return [f"{indent}{_scalar(value)}"]


def _scalar(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else format_atom(value)
