"""The closed loop that claims are about, with exact numbers."""
