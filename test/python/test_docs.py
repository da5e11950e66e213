"""The documentation: it builds without a broken link, and its tutorial runs."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
import yaml

import gprodom
from conftest import CHECKOUT, colours_in

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
    lines = ["import subprocess"]
    for kind, text in blocks:
        run = f"subprocess.run(['sh', '-ec', {text!r}], check=True)"
        lines.append(text if kind == "python" else run)
    environment = {
        **os.environ,
        "PATH": f"{command.parent}:{os.environ['PATH']}",
        "PYTHONPATH": str(Path(gprodom.__file__).resolve().parents[1]),
    }
    result = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)],
        cwd=work,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    for name in ("radar.png", "paths.png", "flags.png", "report/report.html", "many/report.html"):
        content = (work / name).read_bytes()
        assert not name.endswith(".png") or len(colours_in(content)) > 10


def test_documentation_builds(tmp_path: Path) -> None:
    if find_spec("mkdocs") is None:
        pytest.skip("MkDocs is not installed (the extra docs)")
    arguments = ["build", "--strict", "--quiet", "-f", str(CHECKOUT / "mkdocs.yml")]
    result = subprocess.run(
        [sys.executable, "-m", "mkdocs", *arguments, "-d", str(tmp_path / "site")],
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    pages = list((tmp_path / "site").rglob("*.html"))
    assert len(pages) > len(list(DOCS.glob("*.md")))
    outside = re.compile(r"""<(?:script|link|img)[^>]*(?:src|href)=["'](?:https?:)?//""")
    assert [page.name for page in pages if outside.search(page.read_text())] == []


def test_the_page_of_settings_says_where_each_key_of_before_went() -> None:
    page = (CHECKOUT / "docs" / "settings.md").read_text()
    before, now = (
        keys_of(yaml.safe_load((CHECKOUT / path).read_text()))
        for path in ("test/package/gprodom-0.1.yaml", "config/gprodom.yaml")
    )
    gone = {key: value for key, value in before.items() if key not in now}
    assert len(gone) == 70
    for key, value in gone.items():
        row = re.search(rf"^\| `{re.escape(key)}` \| ([^|]+) \|", page, re.M)
        assert row, key
        if re.search(r"\(\S+ in version 0\.1\)", row[0]):
            continue
        told = row[1].strip("`")
        assert told in now or yaml.safe_load(told) == value or float(told) == float(value)
    assert f"There are {sum(not key.startswith('channels.') for key in now)}, " in page


def test_a_setting_that_is_gone_has_the_value_told_in_the_code() -> None:
    page = (CHECKOUT / "docs" / "settings.md").read_text()
    rows = re.findall(r"^\| `\S+` \| (\S+)[^|]* \| (?:`([^`]+)`, )?`([^`]+)` \|", page, re.M)
    assert len(rows) == 59
    for told, constant, path in rows:
        code = (CHECKOUT / "src" / path).read_text()
        if not constant:  # the code has no such choice any more
            continue
        name = re.findall(r"\w+", constant)[-1]
        found = re.search(rf"(\w+ )?\b{name} = ([\w.':+-]+)", code)
        assert found, (constant, path)
        value = found[2].replace("'", "")
        if told[0].isdigit():
            unit = 1e-9 if found[1] == "TimeNs " else 1.0
            assert float(value) * unit == pytest.approx(float(told)), constant
        else:
            assert value.lower().endswith(f"::k{told}"), constant


def keys_of(section: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """The keys of a configuration, with the sections that they are in, and their values."""
    found: dict[str, Any] = {}
    for key, value in section.items():
        if isinstance(value, dict) and value:  # an empty one is the value of a key
            found |= keys_of(value, f"{prefix}{key}.")
        else:
            found[f"{prefix}{key}"] = value
    return found
