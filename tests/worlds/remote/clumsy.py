"""A world whose code raises an exception."""

from rapc.world import Fact, Kit, Offer, Reply, SimpleWorld


class Clumsy(SimpleWorld):
    """A hand that knows no things."""

    name = "clumsy"
    kit = Kit(Offer({"grasp": (1, ("okay",))}))

    def perform(self, ticket: int, request: Fact) -> Reply:
        print("grasping", request)
        return {"mug": Reply("okay")}[str(request[1])]
