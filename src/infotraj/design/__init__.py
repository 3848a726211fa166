"""Flight design: which flight tells most next, given what the flights so far have told."""
