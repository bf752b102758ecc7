"""Tests of the contract between a world and the port: `rapc worlds NAME --test`."""
