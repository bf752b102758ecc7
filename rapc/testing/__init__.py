"""Tests of RAP libraries: `define-test` forms found, run, judged and told of."""
