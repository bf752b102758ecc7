"""Simulated worlds and their handlers, independent of the interpreter."""
