"""Which set of effects is most probable beside a file as wrong as it is."""
