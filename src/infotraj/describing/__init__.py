"""A first vehicle file from a few numbers, and a vehicle file held against a flight."""
