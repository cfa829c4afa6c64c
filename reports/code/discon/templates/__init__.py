"""Texts of the Bladed-style library that do not depend on the law, and where the law goes in."""
