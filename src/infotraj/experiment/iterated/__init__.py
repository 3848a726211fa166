"""Fly, diagnose, design, fly: how many flights until what is hidden has its names."""
