"""The gains of the multi-region wind-turbine controller."""
