"""infotraj: what is missing in a robot's model, and the flights that teach it."""

__version__ = "0.1.0"
