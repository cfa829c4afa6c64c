"""The design of a controller for any plant."""
