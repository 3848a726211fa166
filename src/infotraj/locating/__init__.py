"""Where a model fails: in time, in state and input space, by flight and by axis."""
