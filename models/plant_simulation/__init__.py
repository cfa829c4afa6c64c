"""Simulation of a plant: signals from outside, actuator limits, sampled laws."""
