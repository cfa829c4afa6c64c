"""Gains that are sought, one kind of question a room."""
