"""Dynamic output feedback: controllers with states of their own, by linear matrix inequalities."""
