"""Commands of the debugger, one module for each kind, and a table of all."""
