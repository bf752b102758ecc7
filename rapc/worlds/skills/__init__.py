"""A runtime for networks of skills, for worlds with continuous processes [S 2].

A skill declares its inputs and outputs. The runtime wires a network from the
declarations of the active skills, so no skill depends on another. An author writes
classes of `declarations`; `catalogue` checks a set of skills once; `network` wires the
active skills and draws them; `runtime` switches skills on and off and steps them. The
package depends neither on the interpreter nor on a particular world.
"""
