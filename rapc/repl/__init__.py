"""The REPL of the debugger: commands, tables and the prompt."""
