"""Tests of the interpreter: what a program can observe of it."""
