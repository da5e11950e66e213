"""What code comments and README.md name of the documents is there (MkDocs checks the rest)."""

import re
import subprocess

from conftest import CHECKOUT

DOCS = CHECKOUT / "docs"
SOURCES = ("src", "include", "scripts", "bench", "test", "ros", "ros2", "examples")


def titles(page: str) -> list[str]:
    """Of headings and of paragraphs that begin in bold."""
    text = (DOCS / page).read_text()
    found = re.findall(r"^#+ (.*)$", text, re.M)
    return [*found, *re.findall(r"\*\*([^*]+?)\*\*", text)]


def test_sections_that_comments_name_are_there() -> None:
    listed = subprocess.run(
        ["git", "ls-files", *SOURCES], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    named = []
    for name in listed.stdout.split():
        if not name.endswith((".h", ".cpp", ".py")):
            continue
        # A comment of several lines as one.
        text = re.sub(r"\n\s*(?://|#)\s?", " ", (CHECKOUT / name).read_text())
        for page, quoted in re.findall(r'docs/(\w+\.md), ((?:"[^"\n]+"(?: and |, )?)+)', text):
            assert (DOCS / page).is_file(), (name, page)
            named += [(name, page, title) for title in re.findall(r'"([^"]+)"', quoted)]
    assert len(named) > 20
    there = {page: titles(page) for _, page, _ in named}
    missing = [place for place in named if not any(place[2] in title for title in there[place[1]])]
    assert missing == []


def test_links_of_the_readme_lead_somewhere() -> None:
    links = re.findall(r"\]\(([^)#\s]*)(?:#([^)]*))?\)", (CHECKOUT / "README.md").read_text())
    links = [link for link in links if not link[0].startswith("http")]
    assert len(links) > 20
    for path, anchor in links:
        assert (CHECKOUT / path).exists(), path
        if anchor:
            headings = re.findall(r"^#+ (.*)$", (CHECKOUT / path).read_text(), re.M)
            slugs = {re.sub(r"[^\w\- ]", "", h).strip().lower().replace(" ", "-") for h in headings}
            assert anchor in slugs, (path, anchor)
