"""`rapc lsp`: the language server for editors."""

from __future__ import annotations

import click

from rapc.cli.options import command, fail

EXAMPLES = """\b
Examples:
  rapc lsp
"""


@command(EXAMPLES)
@click.option("--stdio", is_flag=True, help="Accepted; the server has no other mode.")
def lsp(stdio: bool) -> None:
    """Serve an editor over standard input and output (Language Server Protocol).

    An editor starts this command; `docs/how-to/editors` has configurations. The command
    requires the extra `lsp`: `pip install 'rapc[lsp]'`.
    """
    try:
        from rapc.lsp.server import serve
    except ModuleNotFoundError as error:
        if error.name not in ("pygls", "lsprotocol"):
            raise
        fail("`rapc lsp` requires the package pygls", "pip install 'rapc[lsp]'")
    serve()
