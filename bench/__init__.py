"""The benchmarks of rapc: `python -m bench.run`, from the checkout."""
