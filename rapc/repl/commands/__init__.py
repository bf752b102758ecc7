"""The commands of the debugger, a module for each kind, and a table of all."""
