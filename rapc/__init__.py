"""rapc: Reactive Action Packages, checked, run and explained."""

__version__ = "0.1.0"
