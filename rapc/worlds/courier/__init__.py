"""A courier robot in a hospital: a small world in which tasks compete for one body."""

from rapc.worlds.courier.world import CourierWorld

__all__ = ["CourierWorld"]
