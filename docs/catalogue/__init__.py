"""What docs/conditions.md is made of: one entry for each condition, and how a page is printed."""
