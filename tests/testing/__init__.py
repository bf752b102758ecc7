"""Tests of the tests: what `define-test` says of a library, and how it is told."""
