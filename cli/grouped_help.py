"""The help of a verb: its own options, and the others by groups, in short or in full."""

from __future__ import annotations

from typing import Any

from typer.core import TyperCommand

OWN = "Options"
EVERY = "--all-options"
# Grouped options that a help shows in full without being asked.
FEW = 12


class GroupedCommand(TyperCommand):
    """A command whose options stand below the title that each was declared with.

    Of many grouped options the help lists the names; with ``--all-options`` it explains them.
    """

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, the options of the verb itself, and the groups in their order."""
        sections: dict[str, list[tuple[str, str]]] = {"Arguments": [], OWN: []}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is None:
                continue
            is_argument = parameter.param_type_name == "argument"
            title = getattr(parameter, "rich_help_panel", None) or OWN
            sections.setdefault("Arguments" if is_argument else title, []).append(record)
        grouped = {title: sections.pop(title) for title in [*sections][2:]}
        short = not ctx.obj and sum(map(len, grouped.values())) > FEW
        if short:
            sections[OWN].append((EVERY, "Explain the options below too."))
        else:
            sections |= {title: _without_title(title, found) for title, found in grouped.items()}
        for title, records in sections.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)
        for title, records in grouped.items() if short else ():
            names = ", ".join(name.partition(" ")[0] for name, _ in records)
            with formatter.section(title):
                formatter.write_text(names)


def _without_title(title: str, records: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the records without the kind of model that the title says already."""
    kind = f"{title.partition(':')[0].partition(',')[0]}: "
    return [(name, text.removeprefix(kind)) for name, text in records]
