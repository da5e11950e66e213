#!/usr/bin/env python3
"""docs/reference.md: values and reasons of STATUS, flags, commands, options, as the code has them.

Usage: scripts/make_reference.py [--check]

Reads the sources and lcmtypes/ as text, so it needs no build. Fails where the code has a value that
scripts/reference_meanings.toml does not explain, or where that file explains what the code has no
longer. --check writes nothing and fails where the page is not up to date.
"""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[1]
PAGE = CHECKOUT / "docs" / "reference.md"
MOUNTING = "src/input/mounting_watch.cpp"
MEANINGS = CHECKOUT / "scripts" / "reference_meanings.toml"
STRING = r'"((?:[^"\\]|\\.)*)"'
STRINGS = rf"{STRING}(?:\s*{STRING})*"

HEAD = """\
# Reference

Made from the code by `scripts/make_reference.py`; `scripts/check` fails where it is not up to date.
Settings are in `config/gprodom.yaml`, words in the [glossary](glossary.md).
"""


def joined(text: str) -> str:
    """The string literals of a piece of C++, put together."""
    return "".join(re.findall(STRING, text))


def sources(*folders: str) -> Iterator[str]:
    """The text of each C++ source of the folders, bindings excepted."""
    for folder in folders:
        for path in sorted((CHECKOUT / folder).rglob("*")):
            if path.suffix in (".cpp", ".h") and "python" not in path.parts:
                yield path.read_text()


def constants(text: str) -> dict[str, str]:
    """Texts by the names of their constants."""
    found = re.findall(rf"\b(k[A-Z]\w*)\[\]\s*=\s*({STRINGS});", text)
    return {name: joined(literals) for name, literals, *_ in found}


def values_in(text: str, known: dict[str, str]) -> set[str]:
    """Names of the values that a source puts into STATUS; those of one group as `name.*`."""
    name = rf"(?:{STRING}|(k[A-Z]\w*))"
    plain = re.findall(rf"health_\.(?:value|add|maximum)\({name}", text)
    plain += re.findall(rf"\badd\({name}, (?:static_cast<|instance)", text)
    groups = re.findall(rf"\badd\({name}, (?!static_cast<|instance)[\w.()]+, status\)", text)
    return {a or known[b] for a, b in plain} | {f"{a or known[b]}.*" for a, b in groups}


def suffixes(text: str) -> dict[str, list[str]]:
    """The ends of the names of a group, by the type that it is made of."""
    bodies = re.findall(r"void add\(const std::string& name, const (\w+)&(.*?)\n}\n", text, re.S)
    return {kind: re.findall(r'name \+ "(\.\w+)"', body) for kind, body in bodies}


def events_in(text: str, known: dict[str, str]) -> set[str]:
    """Texts that a source counts by channel: the last argument of count(), reject(), notes."""
    found = set()
    calls = r"(?:health_\.count|\.reject|\breject|notes\.(?:push|emplace)_back)\((.*?)\);"
    for call in re.findall(calls, text, re.S):
        last = re.search(rf"({STRINGS})\s*$", call)
        constant = re.search(r"\b(k[A-Z]\w*)\s*$", call)
        if last:
            found.add(joined(last.group(1)))
        elif constant and constant.group(1) in known:
            found.add(known[constant.group(1)])
    return {"…" + text if text.startswith(":") else text for text in found if " " in text}


def refusals_in(text: str, known: dict[str, str]) -> set[str]:
    """Texts that a function of src/input gives as the reason to drop or to count a message."""
    found = set()
    for statement in re.findall(r"(?:\breturn\b|\breason =)([^;]*);", text):
        found |= {joined(m.group(0)) for m in re.finditer(STRINGS, statement)}
        found |= {known[name] for name in re.findall(r"\bk[A-Z]\w*", statement) if name in known}
    return {text for text in found if text}


def reasons_in(text: str, known: dict[str, str]) -> list[tuple[str, str]]:
    """Level and text of each reason of bad health that a source gives."""
    found = []
    for level, rest in re.findall(
        r"health_\.(?:set|await)\([^;]*?HealthLevel::k(\w+),(.*?)\);", text, re.S
    ):
        texts = [joined(m.group(0)) for m in re.finditer(STRINGS, rest)]
        texts += [known[name] for name in re.findall(r"\bk[A-Z]\w*", rest) if name in known]
        found += [(level.lower(), each) for each in texts if each]
    return found


def lcm_constants(name: str) -> list[tuple[str, int, str]]:
    """Name, value and comment of each constant of a message type."""
    text = (CHECKOUT / "lcmtypes" / f"{name}.lcm").read_text()
    found = []
    for names, comment in re.findall(r"const \w+ ([^;]+);[ \t]*(?://[ \t]*(.*))?", text):
        found += [(n, int(v), comment) for n, v in re.findall(r"(\w+) = (-?\d+)", names)]
    return found


def commands_in(text: str) -> list[str]:
    """Names of the commands, from the table of choices."""
    match = re.search(r"names_like\(CommandName\) \{\s*return \{(.*?)\}", text, re.S)
    return re.findall(STRING, match.group(1)) if match else []


def options_in(text: str, known: dict[str, str]) -> list[tuple[str, str, str]]:
    """Option, argument and help of a program's table."""
    rows = re.findall(rf"added_to\(\w+, {STRING},\s*{STRING},\s*({STRINGS})", text)
    options = [(option, argument, joined(words)) for option, argument, words, *_ in rows]
    rows = re.findall(rf"\{{{STRING},\s*{STRING},\s*(.*?),\s*\[", text, re.S)
    for option, argument, words in rows:
        if option.startswith("-"):
            more = "".join(known.get(name, "") for name in re.findall(r"k[A-Z]\w*", words))
            options.append((option, argument, joined(words) + more))
    return options


def subcommands() -> list[tuple[str, str]]:
    """The commands of `gprodom`, each with its line of help."""
    found = []
    for path in sorted((CHECKOUT / "scripts" / "gprodom").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if not (isinstance(node, ast.Call) and getattr(node.func, "id", "") == "add_command"):
                continue
            parent, name, help_text = (ast.unparse(each) for each in node.args[:3])
            group = "" if parent == "subparsers" else f"{path.parent.name} "
            found.append((group + ast.literal_eval(name), ast.literal_eval(help_text)))
    return sorted(found)


def table(head: str, rows: list[tuple[str, ...]]) -> str:
    """A table of Markdown."""
    columns = head.split(" | ")
    lines = [f"| {head} |", "|" + " --- |" * len(columns)]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def values_table(
    text: str, known: dict[str, str], meanings: dict[str, str], faults: list[str]
) -> str:
    """All values of STATUS."""
    ends = suffixes(text)
    durations = ends.get("DurationHistogram", [])
    times = ends.get("WorkTime", [])
    names = values_in(text, known)
    faults += [f"{name}: no meaning in reference_meanings.toml" for name in names - meanings.keys()]
    faults += [f"{name}: the code has no such value" for name in meanings.keys() - names]
    rows = []
    for name in sorted(names):
        end = durations if name.startswith("latency.") else times
        shown = [name] if not name.endswith(".*") else [name[:-2] + each for each in end]
        rows.append((", ".join(f"`{each}`" for each in shown), meanings.get(name, "")))
    return table("value | meaning", rows)


def status_part(code: str, meanings: dict[str, dict[str, str]], faults: list[str]) -> str:
    """Health, reasons, values and counted events."""
    texts, known = meanings["texts"], constants(code)
    silence = re.sub(r'" \+\s*std::to_string\(\w+\) \+\s*"', "N", code)
    reasons = set(reasons_in(silence, known))
    reasons |= {("failed", t) for t in re.findall(rf"reasons\.push_back\({STRING}\)", silence)}
    reasons |= {("degraded", t) for t in re.findall(rf"string reason = {STRING};", code)}
    mounting = mounting_texts()
    reasons |= {("degraded", text) for text in mounting}
    inputs = "\n".join(sources("src/input")).replace((CHECKOUT / MOUNTING).read_text(), "")
    events = (events_in(code, known) | refusals_in(inputs, known)) - {text for _, text in reasons}
    stale = texts.keys() - events - {text for _, text in reasons}
    faults += [f"{text}: the code has no such text" for text in stale]
    health = [(name, str(value)) for name, value, _ in lcm_constants("status_t")]
    why = [(level, text, texts.get(text, "")) for level, text in sorted(reasons)]
    counted = [(text, texts.get(text, "")) for text in sorted(events, key=str.lower)]
    return f"""\
## Health

`health` of `STATUS`, with a reason for each thing that is wrong.

{table("name | value", health)}
## Reasons

A reason begins with its topic: the channel, or a part of the estimator.

{table("level | reason | what it means", why)}
### While it does not start

The reason is `start: …` and one of these, with figures in the place of N:

{start_texts()}
## Values

{values_table(code, known, meanings["values"], faults)}
## Counted events

A value named `CHANNEL: TEXT` counts how often it happened. The log warns of it, at most once in
`logging.warning_period`.

{table("text | what it means", counted)}
A packet that cannot be decoded is counted as `message …` with what is wrong in it. It comes from a
program with another version of the types, or from a foreign one.
"""


def mounting_texts() -> set[str]:
    """What is told of a wrong mounting, without the way out that all of them end in."""
    found = re.findall(rf"\btell\(\s*({STRINGS})", (CHECKOUT / MOUNTING).read_text())
    return {re.sub(r"%[\d.]*[a-z]", "N", joined(literals)) for literals, *_ in found}


def start_texts() -> str:
    """Why the estimator does not start, as a list."""
    code = (CHECKOUT / "src/estimation/initializer.cpp").read_text()
    found = re.findall(rf"(?:refuse\(|nullopt, )\s*({STRINGS})", code)
    texts = {re.sub(r"%[\d.]*[a-z]", "N", joined(literals)) for literals, *_ in found}
    return "".join(f"- {text}\n" for text in sorted(texts))


def messages_part(meanings: dict[str, dict[str, list[str]]], faults: list[str]) -> str:
    """Flags, kinds and commands."""
    flags, kinds, fixes = (
        [(name, str(value), words) for name, value, words in lcm_constants(kind)]
        for kind in ("odometry_t", "displacement_t", "position_fix_t")
    )
    commands = commands_in((CHECKOUT / "include/gprodom/choices.h").read_text())
    known = meanings["commands"]
    faults += [f"{name}: no such command, or no meaning" for name in known.keys() ^ set(commands)]
    rows = [(f"`{name}`", *known.get(name, ("", ""))) for name in commands]
    return f"""\
## Flags

`flags` of `ODOMETRY` and `ODOMETRY_MAP`, added up.

{table("flag | bit | meaning", flags)}
## Kinds of displacement

`kind` of `GPR_DISPLACEMENT`.

{table("kind | value | meaning", kinds)}
## Frames and qualities of a fix

`frame` (SITE, GEODETIC) and `quality` of `POSITION_FIX`.

{table("name | value | meaning", fixes)}
## Commands

`name` and `argument` of a `command_t` on `COMMAND`.

{table("name | argument | what it does", rows)}"""


def programs_part(known: dict[str, str]) -> str:
    """Options of the C++ programs, and the commands of `gprodom`."""
    apps = CHECKOUT / "src" / "apps"
    common = options_in((apps / "command_line.cpp").read_text(), known)
    parts = ["## Programs\n"]
    for program in ("gprodomd", "gprodom_replay"):
        options = common + options_in((apps / f"{program}.cpp").read_text(), known)
        rows = [
            (f"`{name} {argument}`".replace(" `", "`"), words) for name, argument, words in options
        ]
        parts += [f"### {program.replace('_', '-')}\n", table("option | what it does", rows)]
    rows = [(f"`{name}`", words) for name, words in subcommands()]
    parts += ["### gprodom\n\nEach has `--help`.\n", table("command | what it does", rows)]
    return "\n".join(parts)


def reference() -> tuple[str, list[str]]:
    """The page, and what is wrong with the meanings."""
    faults: list[str] = []
    meanings = tomllib.loads(MEANINGS.read_text())
    code = "\n".join(sources("src", "include"))
    status = status_part(code, meanings, faults)
    parts = [HEAD, status, messages_part(meanings, faults), programs_part(constants(code))]
    return "\n".join(parts), faults


def main() -> int:
    """Writes the page, or checks it."""
    page, faults = reference()
    if "--check" not in sys.argv[1:]:
        PAGE.write_text(page)
    elif not PAGE.exists() or PAGE.read_text() != page:
        faults.append(
            "docs/reference.md is not up to date: scripts/make_reference.py writes it anew"
        )
    print("\n".join(faults) or "docs/reference.md: as the code has it")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
