"""The tests of rapc: a folder for each room of the house, and tests of the whole."""
