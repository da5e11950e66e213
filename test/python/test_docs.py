"""The documentation: it builds without a broken link, and its tutorial runs."""

import os
import re
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import gprodom
from conftest import CHECKOUT, colours_in, run_program

DOCS = CHECKOUT / "docs"


@pytest.mark.usefixtures("compiled")
def test_tutorial_runs(tmp_path: Path) -> None:
    """Its blocks in order: commands by a shell, Python in one interpreter."""
    blocks = re.findall(r"^```(\w+)\n(.*?)^```$", (DOCS / "tutorial.md").read_text(), re.M | re.S)
    assert {kind for kind, _ in blocks} == {"sh", "python"}
    command = tmp_path / "bin" / "gprodom"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m gprodom "$@"\n')
    command.chmod(0o755)
    work = tmp_path / "work"
    work.mkdir()
    # One program: each shell block as a call, so that Python blocks see what came before.
    lines = ["import os, subprocess", f"os.chdir({str(work)!r})"]
    for kind, text in blocks:
        run = f"subprocess.run(['sh', '-ec', {text!r}], check=True)"
        lines.append(text if kind == "python" else run)
    paths = f"{command.parent}:{os.environ['PATH']}"
    scripts = str(Path(gprodom.__file__).resolve().parents[1])
    run_program(sys.executable, "-c", "\n".join(lines), PATH=paths, PYTHONPATH=scripts)
    for name in ("radar.png", "paths.png", "flags.png", "report/report.html", "many/report.html"):
        content = (work / name).read_bytes()
        assert not name.endswith(".png") or len(colours_in(content)) > 10


def test_documentation_builds(tmp_path: Path) -> None:
    if find_spec("mkdocs") is None:
        pytest.skip("MkDocs is not installed (the extra docs)")
    arguments = ["build", "--strict", "--quiet", "-f", str(CHECKOUT / "mkdocs.yml")]
    run_program(sys.executable, "-m", "mkdocs", *arguments, "-d", tmp_path / "site")
    pages = list((tmp_path / "site").rglob("*.html"))
    assert len(pages) > len(list(DOCS.glob("*.md")))
    outside = re.compile(r"""<(?:script|link|img)[^>]*(?:src|href)=["'](?:https?:)?//""")
    assert [page.name for page in pages if outside.search(page.read_text())] == []
