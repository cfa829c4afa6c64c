"""Equilibria of a turbine at each constant wind: how many there are, counted with proof."""
