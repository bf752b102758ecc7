"""docs/libraries/hallway.md names tests of each paragraph, and shows a frame.

python -m tests.docs.test_library_hallway_page    writes the frame anew
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from tests.cli.command import rapc
from tests.docs.pages import rows, ticked

ROOT = Path(__file__).parents[2]
FILE = ROOT / "docs" / "libraries" / "hallway.md"
PAGE = FILE.read_text(encoding="utf-8")
FRAME = re.compile(r"(?<=^```text\n).*?(?=^```$)", re.M | re.S)


def test_every_test_of_the_table_of_paragraphs_is_there() -> None:
    listed = rows(PAGE, "paragraph")
    texts = [
        file.read_text(encoding="utf-8")
        for folder in ("stdlib/hallway", "tests/rap", "tests/hallway")
        for file in (ROOT / folder).iterdir()
        if file.name.endswith((".test.rap", ".py"))
    ]
    defined = set(
        re.findall(r"^(?:\(define-test|def) ([\w-]+)", "\n".join(texts), re.M)
    )
    named = {name for row in listed for name in ticked(row[-1])}
    assert named <= defined
    paragraphs = {row[0].strip() for row in listed}
    assert paragraphs == {"3", "3.1", "3.2", "3.3", "4", "4.1", "4.2", "4.2.1", "4.3"}


def _frame(folder: Path) -> str:
    """Return what the command of the page draws in a folder with its one file."""
    [command] = re.findall(r"^rapc (run .* --show)$", PAGE, re.M)
    text, *_ = re.findall(r"^```rap\n(.*?)^```", PAGE, re.M | re.S)
    (folder / "robot.rap").write_text(text, encoding="utf-8")
    done = rapc(*command.split(), cwd=folder, COLUMNS="72", LINES="36")
    assert done.stderr == ""
    return done.stdout.partition("Run over")[0]


def test_the_frame_is_what_is_drawn(tmp_path: Path) -> None:
    assert FRAME.findall(PAGE) == [_frame(tmp_path)]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        drawn = _frame(Path(made))
    FILE.write_text(FRAME.sub(lambda _: drawn, PAGE), encoding="utf-8")
