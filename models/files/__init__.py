"""What model files have in common."""
