"""The loop closed with named effects: does a controller with them fly better."""
