#!/usr/bin/env python3
"""How much code there is: lines of C++ without blanks and comments, and constants.

`constants` are the names that begin with k and are set at their declaration; `numbers` are numeric
literals other than 0, 1, 2 and 0.5. With --at, of a commit and not of the files as they are.

    scripts/count_code.py [--at COMMIT] [FOLDER...]     (default: src include)
"""

from __future__ import annotations

import argparse
import re
import subprocess
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LITERAL = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'')
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
CONSTANT = re.compile(r"\bk[A-Z]\w*(?:\[\])?\s*(?:=(?!=)|\{)")
NUMBER = re.compile(r"(?<![\w.])(?:\d[\d']*\.?\d*|\.\d+)(?:e[-+]?\d+)?(?![\w.])")
PLAIN = {0.0, 1.0, 2.0, 0.5}


def code_of(text: str) -> str:
    """The text without comments, and with empty strings."""
    return COMMENT.sub(" ", LITERAL.sub('""', text))


def count(text: str) -> Counter[str]:
    """Of one file."""
    code = code_of(text)
    numbers = [float(each.replace("'", "")) for each in NUMBER.findall(code)]
    return Counter(
        lines=sum(bool(line.strip()) for line in code.splitlines()),
        constants=len(CONSTANT.findall(code)),
        numbers=sum(number not in PLAIN for number in numbers),
    )


def git(*words: str) -> str:
    """What git says."""
    return subprocess.run(
        ["git", *words], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout


def main() -> None:
    """Prints a row for each folder below the given ones, and the sum."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--at", metavar="COMMIT")
    parser.add_argument("folders", nargs="*", metavar="FOLDER", default=["src", "include"])
    args = parser.parse_args()
    listed = ["ls-tree", "-r", "--name-only", args.at] if args.at else ["ls-files", "-co"]
    sums: dict[str, Counter[str]] = {}
    for name in sorted(git(*listed, "--", *args.folders).split()):
        if Path(name).suffix not in (".h", ".cpp") or not (args.at or (ROOT / name).exists()):
            continue
        text = git("show", f"{args.at}:{name}") if args.at else (ROOT / name).read_text()
        folder = "/".join(Path(name).parts[:2])
        for key in (folder, "all"):
            sums.setdefault(key, Counter()).update(count(text))
    for name, each in sorted(sums.items(), key=lambda item: (item[0] == "all", item[0])):
        print(
            f"{name:20s} {each['lines']:6d} lines {each['constants']:5d} constants "
            f"{each['numbers']:5d} numbers"
        )


if __name__ == "__main__":
    main()
