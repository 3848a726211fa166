"""The simulated omav: MuJoCo for the bodies, and the hidden effects that its truth file states."""
