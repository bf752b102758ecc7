"""An engine that behaves badly: `fake_engine.py DEED DOMAIN PROBLEM PLAN`.

The plan for the courier is right where a deed does not say otherwise.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

PLAN = """(fetch_medicine_ward-3_base_pharmacy)
(BRING_medicine_ward-3_pharmacy ) ; the case of letters does not matter

(travel-to_base_ward-3)
(go-into-dock)
; cost = 4 (unit cost)
"""
MUCH = 10_000_000


def main(deed: str, plan: Path) -> None:
    """Do a deed."""
    if deed == "print-much":
        sys.stdout.write("x" * MUCH)
        sys.stderr.write("y" * MUCH)
    elif deed == "print-much-and-fail":
        print("x" * MUCH, flush=True)
        sys.exit("out of memory in " + str(plan))
    elif deed == "close-output":
        os.close(1)
        os.close(2)
    elif deed == "fail":
        sys.exit(3)
    elif deed == "die":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif deed == "die-of-another-signal":
        os.kill(os.getpid(), 40)
    elif deed == "kill-parent":
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(60)
    elif deed == "hang":
        hang()
    plan.write_bytes(
        {
            "half": PLAN[:44].encode(),
            "too-short": PLAN.encode()[: PLAN.index("(travel")],
            "wrong-order": b"(travel-to_base_ward-3)\n" * 2 + PLAN.encode(),
            "unknown": b"(fetch_medicine_ward-3_base_pharmacy)\n(fly)\n",
            "no-steps": b"",
            "rubbish": bytes(range(256)) * 20,
            "write-much": b"(go-into-dock)\n" * (MUCH // 15),
            "one-long-line": b"(" * MUCH,
        }.get(deed, PLAN.encode())
    )
    if deed == "leave-a-process":
        tell_pids(sleeping())
    elif deed == "plan-and-fail":
        sys.exit(12)


def hang() -> None:
    """Ignore signals, start a process that does so, and write the numbers of both."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    tell_pids(os.getpid(), sleeping())
    time.sleep(60)


def sleeping() -> int:
    """Start a process that sleeps, and return its number."""
    code = "import time; time.sleep(60)"
    return subprocess.Popen([sys.executable, "-c", code]).pid


def tell_pids(*found: int) -> None:
    """Write the numbers of processes to the file of the environment, all at once."""
    file = Path(os.environ["FAKE_ENGINE_PIDS"])
    file.with_suffix(".part").write_text(" ".join(map(str, found)))
    file.with_suffix(".part").rename(file)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[4]))
