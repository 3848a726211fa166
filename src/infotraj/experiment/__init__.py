"""The stages of the experiment, each one call that reads files and writes files."""
