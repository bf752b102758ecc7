"""The version of rapc, for the package, the command line and compiled libraries."""

VERSION = "0.1.0"
