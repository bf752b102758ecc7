"""The delivery truck world (T 6.1, appendix B)."""

from rapc.worlds.truck.world import TruckWorld

__all__ = ["TruckWorld"]
