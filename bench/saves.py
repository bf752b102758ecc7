"""Saves by an editor while `rapc fmt` and `rapc check --fix` work on the same file.

    python -m bench.saves               # 200 saves during each command
    python -m bench.saves --saves 50 --raps 1000

Each command begins on a file that it would change. At a random moment another text is
saved, in turn by a rename and in place. A save is lost if the file does not hold it
when the command has ended. The exit status is the number of lost saves, 1 at most.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

COMMANDS = {"fmt": ("fmt",), "check --fix": ("check", "--fix", "--no-cache")}

RAP = "(define-rap (a{})(succeed (and t t))(method (task-net (t1 (a0)))))\n"


def text(raps: int, mark: str) -> str:
    """Return a text that both commands would change, with a comment that marks it."""
    unused = f"; {mark}\n; rapc: ignore[unknown-rap] nothing to ignore\n"
    return unused + "".join(RAP.format(n) for n in range(raps))


def save(file: Path, content: str, *, in_place: bool) -> None:
    """Save a file as one of two sorts of editors does."""
    if in_place:
        file.write_text(content)
    else:
        new = file.with_name("new")
        new.write_text(content)
        new.replace(file)


def run(command: tuple[str, ...], file: Path) -> subprocess.Popen[str]:
    """Begin a command on a file."""
    rapc = [str(Path(sys.executable).with_name("rapc")), *command, file.name]
    return subprocess.Popen(
        rapc, cwd=file.parent, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def came_of(file: Path, done: subprocess.Popen[str], mark: str) -> str:
    """Wait for a command to end; return what became of the save during it."""
    _, said = done.communicate()
    if mark not in file.read_text():
        return "lost"
    changed = "the file changed after rapc read it" in said
    return "during the work" if changed else "before or after it"


def main() -> None:
    """Print for each command how many saves were lost, and when the others were."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--saves", type=int, default=200)
    parser.add_argument("--raps", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    chance = random.Random(asked.seed)
    lost = 0
    for name, command in COMMANDS.items():
        found: Counter[str] = Counter()
        with TemporaryDirectory() as folder:
            file = Path(folder) / "one.rap"
            file.write_text(text(asked.raps, "first"))
            began = time.monotonic()
            run(command, file).communicate()
            taken = time.monotonic() - began
            for number in range(asked.saves):
                file.write_text(text(asked.raps, "first"))
                done = run(command, file)
                time.sleep(chance.uniform(0, 1.1 * taken))
                mark = f"save {number}."
                save(file, text(asked.raps, mark), in_place=bool(number % 2))
                found[came_of(file, done, mark)] += 1
        lost += found["lost"]
        told = ", ".join(f"{count} {what}" for what, count in sorted(found.items()))
        print(f"{name}: {asked.saves} saves: {told}")
    raise SystemExit(bool(lost))


if __name__ == "__main__":
    main()
