"""Tests of RAP libraries: find, run, judge and report `define-test` forms."""
