"""The first-principles model h (eq. 3, eq. 19): rigid body, actuators, allocation, all from the vehicle file."""
