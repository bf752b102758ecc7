"""A courier robot in a hospital: a small world in which tasks want one body."""

from rapc.worlds.courier.world import CourierWorld

__all__ = ["CourierWorld"]
