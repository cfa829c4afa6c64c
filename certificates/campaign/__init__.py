"""Random simulations of a certified loop, within its class and outside; nothing is proved."""
