"""What is to be flown: references, tasks and the deviations that turn a task into a candidate."""
