"""The words and the style of the HTML report: Jinja templates and one style sheet."""
