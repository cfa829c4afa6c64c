"""The page of `takagi explore`: its text, its script and its style."""
