"""What all stages share: configuration, jobs, randomness, tables."""
