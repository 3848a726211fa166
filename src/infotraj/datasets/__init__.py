"""Public data sets: where they lie on this machine, and how their files become flight tables."""
