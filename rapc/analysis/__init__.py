"""The checker: passes over a linked library, and the driver that runs them."""
