"""The loop that requests are about, and the search tools."""
