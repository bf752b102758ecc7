"""The debugger, without terminal and protocol: step a run, ask it, go back."""
