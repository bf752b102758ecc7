"""Units of files that were read before, for those who read the same files again."""

from __future__ import annotations

from rapc.base.source import SourceFile
from rapc.parser.parse import parse
from rapc.parser.unit import SourceUnit


class Units:
    """Reads files, and remembers what it made of them as long as they stay the same.

    For `rapc.library.loader.load` and its like, as their `parser`.
    """

    def __init__(self) -> None:
        self._made: dict[str, SourceUnit] = {}

    def __call__(self, source: SourceFile) -> SourceUnit:
        """Return the unit of a file; it is parsed unless its text is as before."""
        made = self._made.get(source.name)
        if made is None or made.file.text != source.text:
            made = self._made[source.name] = parse(source)
        return made
