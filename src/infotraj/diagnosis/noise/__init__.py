"""How much each frequency of each axis is believed."""
