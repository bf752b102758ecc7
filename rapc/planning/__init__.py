"""Plans for goals that no method reaches: RAPs with `effects` are the operators.

`rapc.library.operators` makes operators from RAPs, `ground` their instances for a
situation, `search` finds a sequence of instances, `sketch` makes a partly ordered
task-net from it, and `solver` puts these together. `pddl` writes a problem for other
planners, `engines` asks them, and `from_pddl` reads domains. The interpreter never
imports this package: a host gives it the function that plans (`rapc.host`).
"""
