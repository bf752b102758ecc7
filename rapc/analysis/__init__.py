"""The checker: checks of a linked library, and the driver that runs the checks."""
