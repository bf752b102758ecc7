"""The map of T 6.1, as near as its text describes it.

Quarries to the right, factories to the left, six zones between them; the warehouse
above, the depot below. A road takes about 32 time units and 0.6 of fuel: a journey
from a quarry to its factory and back, six roads, some 200 units and 3.8 of fuel. In
the zones lies nothing at first: others disperse what the quarries make (T 6.1.2).
"""

MAP = """\
{"start": "depot", "heading": "north",
 "places": [
  {"name": "factory-1", "kind": "factory"},
  {"name": "factory-2", "kind": "factory"},
  {"name": "factory-3", "kind": "factory"},
  {"name": "zone-1", "kind": "zone"}, {"name": "zone-2", "kind": "zone"},
  {"name": "zone-3", "kind": "zone"}, {"name": "zone-4", "kind": "zone"},
  {"name": "zone-5", "kind": "zone"}, {"name": "zone-6", "kind": "zone"},
  {"name": "quarry-1", "kind": "quarry", "color": "red"},
  {"name": "quarry-2", "kind": "quarry", "color": "blue"},
  {"name": "quarry-3", "kind": "quarry", "color": "yellow"},
  {"name": "warehouse", "kind": "warehouse"},
  {"name": "depot", "kind": "depot"}],
 "roads": [
  {"name": "road-1", "from": "factory-1", "direction": "east", "to": "zone-1",
   "time": 32, "fuel": 0.6},
  {"name": "road-2", "from": "zone-1", "direction": "east", "to": "zone-2",
   "time": 34, "fuel": 0.68},
  {"name": "road-3", "from": "zone-2", "direction": "east", "to": "quarry-1",
   "time": 32, "fuel": 0.6},
  {"name": "road-4", "from": "factory-2", "direction": "east", "to": "zone-3",
   "time": 32, "fuel": 0.6},
  {"name": "road-5", "from": "zone-3", "direction": "east", "to": "zone-4",
   "time": 34, "fuel": 0.68},
  {"name": "road-6", "from": "zone-4", "direction": "east", "to": "quarry-2",
   "time": 32, "fuel": 0.6},
  {"name": "road-7", "from": "factory-3", "direction": "east", "to": "zone-5",
   "time": 32, "fuel": 0.6},
  {"name": "road-8", "from": "zone-5", "direction": "east", "to": "zone-6",
   "time": 34, "fuel": 0.68},
  {"name": "road-9", "from": "zone-6", "direction": "east", "to": "quarry-3",
   "time": 32, "fuel": 0.6},
  {"name": "road-10", "from": "zone-1", "direction": "south", "to": "zone-3",
   "time": 29, "fuel": 0.56},
  {"name": "road-11", "from": "zone-3", "direction": "south", "to": "zone-5",
   "time": 29, "fuel": 0.56},
  {"name": "road-12", "from": "zone-2", "direction": "south", "to": "zone-4",
   "time": 29, "fuel": 0.56},
  {"name": "road-13", "from": "zone-4", "direction": "south", "to": "zone-6",
   "time": 29, "fuel": 0.56},
  {"name": "road-14", "from": "warehouse", "direction": "southwest", "to": "zone-1",
   "time": 29, "fuel": 0.56},
  {"name": "road-15", "from": "warehouse", "direction": "southeast", "to": "zone-2",
   "time": 29, "fuel": 0.56},
  {"name": "road-16", "from": "depot", "direction": "northwest", "to": "zone-5",
   "time": 29, "fuel": 0.56},
  {"name": "road-17", "from": "depot", "direction": "northeast", "to": "zone-6",
   "time": 29, "fuel": 0.56},
  {"name": "road-18", "from": "zone-1", "direction": "southeast", "to": "zone-4",
   "time": 41, "fuel": 0.8},
  {"name": "road-19", "from": "zone-4", "direction": "southwest", "to": "zone-5",
   "time": 41, "fuel": 0.8}],
 "items": [
  {"kind": "rock", "color": "red", "place": "quarry-1", "count": 4},
  {"kind": "rock", "color": "blue", "place": "quarry-2", "count": 4},
  {"kind": "rock", "color": "yellow", "place": "quarry-3", "count": 4},
  {"kind": "fuel-drum", "place": "depot", "count": 6},
  {"kind": "gun", "place": "warehouse"},
  {"kind": "gun-tool", "place": "warehouse"},
  {"kind": "ammo-box", "place": "warehouse", "count": 4}],
 "sectors": [
  {"name": "west", "spots": ["factory-1", "factory-2", "factory-3",
   "road-1", "road-4", "road-7"]},
  {"name": "middle", "spots": ["zone-1", "zone-2", "zone-3", "zone-4", "zone-5",
   "zone-6", "road-2", "road-5", "road-8", "road-10", "road-11", "road-12",
   "road-13", "road-18", "road-19"]},
  {"name": "east", "spots": ["quarry-1", "quarry-2", "quarry-3",
   "road-3", "road-6", "road-9"]},
  {"name": "north", "spots": ["warehouse", "road-14", "road-15"]},
  {"name": "south", "spots": ["depot", "road-16", "road-17"]}]}
"""
"""JSON for `rapc.worlds.truck.map.read_map`."""
