"""Script mode: inputs one after the other, each answered, without a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TextIO

import msgspec

from rapc.debug.arguments import is_balanced
from rapc.repl.draw import draw
from rapc.repl.shell import Shell


def inputs(lines: Iterable[str]) -> Iterator[str]:
    """Iterate over the inputs in some lines: a list may go over several of them."""
    gathered = ""
    for line in lines:
        gathered = f"{gathered}\n{line.rstrip()}" if gathered else line.strip()
        if gathered.startswith(":") or is_balanced(gathered):
            if gathered:
                yield gathered
            gathered = ""
    if gathered:
        yield gathered


def run_script(
    shell: Shell,
    texts: Iterable[str],
    stream: TextIO,
    width: int,
    *,
    color: bool = False,
    as_json: bool = False,
) -> bool:
    """Carry out inputs one after the other, and write what each has to say.

    Args:
        shell: answers them.
        texts: the inputs.
        stream: where the answers go.
        width: how many columns an answer may take.
        color: whether answers are coloured.
        as_json: whether each answer is written as a line of JSON instead.

    Returns:
        Whether all of them could be carried out.
    """
    well = True
    for text in texts:
        answer = shell.answer(text)
        well = well and not answer.failed
        if as_json:
            record = {"input": text, **answer.record()}
            stream.write(msgspec.json.encode(record, enc_hook=str).decode() + "\n")
        else:
            stream.write(draw(answer, width, color=color))
        stream.flush()
        if shell.left:
            break
    return well
