"""The building that the world begins with.

Four hallways in a ring around a court, rooms on both sides of them, and a second floor
that the lift leads to: seventeen spaces.
"""

MAP = """\
start = "charger"

[[space]]
name = "north-hall"
kind = "hall"
box = [2.2, 13.0, 19.8, 15.0]
[[space]]
name = "east-hall"
kind = "hall"
box = [20.0, 2.2, 22.0, 15.0]
[[space]]
name = "south-hall"
kind = "hall"
box = [2.2, 0.0, 22.0, 2.0]
[[space]]
name = "west-hall"
kind = "hall"
box = [0.0, 0.0, 2.0, 15.0]

[[space]]
name = "lab"
box = [2.2, 15.2, 8.0, 20.0]
[[space]]
name = "office"
box = [8.2, 15.2, 13.0, 20.0]
[[space]]
name = "library"
box = [13.2, 15.2, 19.8, 20.0]
[[space]]
name = "workshop"
box = [22.2, 9.0, 28.0, 15.0]
[[space]]
name = "store"
box = [22.2, 3.0, 28.0, 8.8]
[[space]]
name = "kitchen"
box = [2.2, -5.0, 8.0, -0.2]
[[space]]
name = "meeting-room"
box = [8.2, -5.0, 15.0, -0.2]
[[space]]
name = "mail-room"
box = [15.2, -5.0, 20.0, -0.2]
[[space]]
name = "court"
box = [6.0, 5.0, 16.0, 12.8]
[[space]]
name = "lift"
kind = "lift"
box = [-2.4, 6.0, -0.2, 8.2]
floors = [1, 2]
[[space]]
name = "upper-hall"
kind = "hall"
box = [0.0, 0.0, 2.0, 15.0]
floors = [2]
[[space]]
name = "study"
box = [2.2, 8.0, 8.0, 13.0]
floors = [2]
[[space]]
name = "attic"
box = [2.2, 1.0, 8.0, 7.0]
floors = [2]

[[doorway]]
name = "north-west-door"
joins = ["north-hall", "west-hall"]
at = 14.0
tags = [20, 21]
[[doorway]]
name = "north-east-door"
joins = ["north-hall", "east-hall"]
at = 14.0
tags = [22, 23]
[[doorway]]
name = "south-west-door"
joins = ["south-hall", "west-hall"]
at = 1.0
tags = [24, 25]
[[doorway]]
name = "south-east-door"
joins = ["south-hall", "east-hall"]
at = 21.0
tags = [26, 27]
[[doorway]]
name = "lab-door"
joins = ["lab", "north-hall"]
at = 5.0
tags = [2, 3]
door = true
says = "the door of the laboratory"
[[doorway]]
name = "office-door"
joins = ["office", "north-hall"]
at = 10.5
tags = [4, 5]
door = true
[[doorway]]
name = "library-door"
joins = ["library", "north-hall"]
at = 16.5
tags = [6, 7]
[[doorway]]
name = "lab-office-door"
joins = ["lab", "office"]
at = 17.5
tags = [8, 9]
door = true
[[doorway]]
name = "workshop-door"
joins = ["workshop", "east-hall"]
at = 12.0
tags = [10, 11]
door = true
[[doorway]]
name = "store-door"
joins = ["store", "east-hall"]
at = 6.0
tags = [12, 13]
[[doorway]]
name = "workshop-store-door"
joins = ["workshop", "store"]
at = 25.5
tags = [14, 15]
door = true
[[doorway]]
name = "kitchen-door"
joins = ["kitchen", "south-hall"]
at = 5.0
tags = [16, 17]
[[doorway]]
name = "meeting-room-door"
joins = ["meeting-room", "south-hall"]
at = 11.5
tags = [18, 19]
door = true
[[doorway]]
name = "mail-room-door"
joins = ["mail-room", "south-hall"]
at = 17.5
tags = [28, 29]
[[doorway]]
name = "court-door"
joins = ["court", "north-hall"]
at = 11.0
tags = [30, 31]
door = true
[[doorway]]
name = "lower-lift-door"
joins = ["lift", "west-hall"]
at = 7.1
tags = [32, 33]
[[doorway]]
name = "upper-lift-door"
joins = ["lift", "upper-hall"]
at = 7.1
tags = [34, 35]
[[doorway]]
name = "study-door"
joins = ["study", "upper-hall"]
at = 10.5
tags = [36, 37]
door = true
[[doorway]]
name = "attic-door"
joins = ["attic", "upper-hall"]
at = 4.0
tags = [38, 39]

[[landmark]]
name = "charger"
space = "lab"
wall = "west"
at = 17.5
tags = [0, 1]
charger = true
says = "the charger"
[[landmark]]
name = "desk"
space = "office"
wall = "north"
at = 10.5
tags = [40, 41]
says = "the desk"
[[landmark]]
name = "shelves"
space = "library"
wall = "east"
at = 17.5
tags = [42, 43]
says = "the shelves"
[[landmark]]
name = "workbench"
space = "workshop"
wall = "east"
at = 12.0
tags = [44, 45]
says = "the workbench"
[[landmark]]
name = "stock"
space = "store"
wall = "east"
at = 6.0
tags = [46, 47]
says = "the stock"
[[landmark]]
name = "coffee-machine"
space = "kitchen"
wall = "south"
at = 5.0
tags = [48, 49]
says = "the coffee machine"
[[landmark]]
name = "blackboard"
space = "meeting-room"
wall = "east"
at = -2.5
tags = [50, 51]
says = "the blackboard"
[[landmark]]
name = "mail-slots"
space = "mail-room"
wall = "south"
at = 17.5
tags = [52, 53]
says = "the mail slots"
[[landmark]]
name = "fountain"
space = "court"
wall = "south"
at = 11.0
tags = [54, 55]
says = "the fountain"
[[landmark]]
name = "armchair"
space = "study"
wall = "east"
at = 10.5
tags = [56, 57]
says = "the armchair"
[[landmark]]
name = "chest"
space = "attic"
wall = "east"
at = 4.0
tags = [58, 59]
says = "the chest"

[[obstacle]]
box = [13.6, 14.55, 14.2, 15.0]
[[obstacle]]
box = [20.0, 8.6, 20.5, 9.2]
[[obstacle]]
box = [8.0, 0.0, 8.7, 0.5]
[[obstacle]]
box = [1.6, 10.6, 2.0, 11.4]
[[obstacle]]
box = [24.8, 13.2, 25.6, 14.0]
[[obstacle]]
box = [9.6, -3.8, 11.0, -2.8]
[[obstacle]]
box = [10.2, 8.2, 11.8, 9.4]

[[person]]
space = "north-hall"
[[person]]
space = "south-hall"
speed = 0.7
[[person]]
space = "west-hall"
speed = 0.9
[[person]]
space = "office"
[[person]]
space = "meeting-room"
speed = 0.6
[[person]]
space = "upper-hall"
"""
