"""Commands that a log holds less often than they were given: they made several steps from one row to the next."""

COMMAND_STEPS = "command_steps"  # in a flight's metadata: how many steps. 1, or absent: the commands were held
MOST_STEPS = 200  # time and memory grow with them
