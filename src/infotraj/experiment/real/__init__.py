"""Recorded real flights: models held against them, cases of a known change, a pool to choose from."""
