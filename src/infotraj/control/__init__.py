"""The controller of eq. 20: feedforward, PID on position and attitude, inversion of h + mu."""
