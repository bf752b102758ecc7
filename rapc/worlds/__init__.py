"""Simulated worlds and their handlers; none of them knows the interpreter."""
