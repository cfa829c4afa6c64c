"""A page as its reader finds it: elements, headings, links; and a section as text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from html.parser import HTMLParser

import pytest

from takagi.certificates import Checked, Claim
from takagi.certificates.checker.replay.certificate import concluded
from takagi.reports.figures import style
from takagi.reports.page.assembly import render
from takagi.reports.page.text import Section

VOID = {"area", "base", "br", "col", "hr", "img", "input", "link", "meta", "source", "wbr"}


@contextmanager
def unsettled() -> Iterator[pytest.MonkeyPatch]:
    """Make no room for labels, a quarter of a page's time; ``test_figures`` looks at it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "_settle", lambda figure: figure.set_layout_engine(None))
        yield patch


class HtmlPage(HTMLParser):
    """Notes what a page and its cells contain, and every tag that is closed out of turn."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.wrong: list[str] = []
        self.cells: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] in ("td", "th"):
            self.cells[-1] += data

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def all(self, tag: str) -> Iterator[dict[str, str | None]]:
        return (attributes for name, attributes in self.tags if name == tag)

    @property
    def ids(self) -> list[str]:
        return [str(a["id"]) for _, a in self.tags if a.get("id")]


def self_contained(html: str) -> HtmlPage:
    """Return the page: well-formed, nothing is loaded, every id once, every link has its place."""
    page = HtmlPage(html)
    ids = set(page.ids)
    assert page.wrong == [] and page.open == []
    assert len(page.ids) == len(ids)
    assert not {"script", "link", "img", "iframe", "object"} & {tag for tag, _ in page.tags}
    assert not re.search(r"url\((?!#)|@import", html)
    links = [a.get(key) for _, a in page.tags for key in ("src", "href", "xlink:href")]
    assert all(link.startswith("#") and link[1:] in ids for link in links if link)
    return page


def text_of(section: Section) -> str:
    return render(section, "turbine")


def checked_as(claims: list[Claim]) -> Checked:
    return concluded(claims, [])
