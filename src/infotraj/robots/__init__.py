"""Who flies a reference: a simulated vehicle, a log that is waited for, a pool of recorded flights."""
