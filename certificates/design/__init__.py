"""From a turbine or plant, or from gains that exist, to a law with its checked certificate."""
