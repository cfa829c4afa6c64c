"""The help of a verb, with its options below the titles of their groups."""

from __future__ import annotations

from typing import Any

from typer.core import TyperCommand

OWN = "Options"


class GroupedCommand(TyperCommand):
    """A command whose options stand below the title that each was declared with."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, the options of the verb itself, and each group in its order."""
        sections: dict[str, list[tuple[str, str]]] = {"Arguments": [], OWN: []}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is None:
                continue
            is_argument = parameter.param_type_name == "argument"
            title = getattr(parameter, "rich_help_panel", None) or OWN
            sections.setdefault("Arguments" if is_argument else title, []).append(record)
        for title, records in sections.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)
