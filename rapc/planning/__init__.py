"""Plans for goals that no method reaches: RAPs with `effects` are the operators.

`rapc.library.operators` makes operators from RAPs, `ground` their instances for a
situation, `search` finds a sequence of instances, `sketch` makes a partly ordered
task-net from it, and `solver` puts these together. The interpreter never imports this
package: a host gives it the function that plans (`rapc.host`).
"""
