"""`python -m rapc.worlds.remote WORLD [ADDRESS]`: serve a Python world.

WORLD is an installed world or `module:Class`. Without ADDRESS (`unix:/path` or
`tcp:127.0.0.1:PORT`) the world is served on standard input and output.
"""

from __future__ import annotations

import sys

from rapc.errors import Error, in_a_line
from rapc.worlds.registry import find_world
from rapc.worlds.remote.server import listen, serve


def main(arguments: list[str]) -> str | None:
    """Serve the world; return an error, or None at the end."""
    if not 1 <= len(arguments) <= 2:
        return "usage: python -m rapc.worlds.remote WORLD [ADDRESS]"
    name = arguments[0]
    try:
        world = find_world(name)
        code = "" if ":" in name else name
        if len(arguments) == 1:
            serve(world, code)
        else:
            listen(world, arguments[1], code)
    except Error as error:
        return in_a_line(error)
    except (OSError, ValueError) as error:
        return f"cannot serve `{name}`: {error}"
    except KeyboardInterrupt:
        pass  # the user ends the server
    return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
