"""How much there is to read: lines of code, constants, long functions and words, by commit.

    python bench/code_size.py                    # what is checked out, as committed
    python bench/code_size.py 845eaf0 HEAD       # two commits side by side

A line of code has something on it that is neither a blank, a comment nor a docstring. Constants are
those of `motion` and `estimation`: names (kName), and numbers other than 0, 1, 2 and 0.5. A long
function has more than 60 lines from its first to its last. Words are those of README.md and docs/
that a person wrote, counted between blanks.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from pygments.lexers import CppLexer, PythonLexer
from pygments.token import Comment, Number, String

from program import complain, parser_of, print_figures, table_of

ROOT = Path(__file__).resolve().parents[1]
CODE = {
    "C++ (src, include)": re.compile(r"(src|include)/.*\.(cpp|h)"),
    "C++ (test, bench, ros)": re.compile(r"(test|bench|ros|ros2|examples)/.*\.(cpp|h)"),
    "Python (package)": re.compile(r"scripts/gprodom/.*\.py"),
    "Python (test)": re.compile(r"test/.*\.py"),
    "Python (bench, scripts)": re.compile(r"(bench/.*|scripts/[^/]*)\.py"),
}
MODELS = re.compile(r"src/(motion|estimation)/.*\.(cpp|h)")
DOCUMENT = re.compile(r"(README|docs/[^/]*)\.md")
GENERATED = ("docs/reference.md", "docs/results.md")
LONG = 60
PLAIN = {0.0, 1.0, 2.0, 0.5}  # numbers that need no reason
NAMED = re.compile(r"\bk[A-Z]\w*(?=\s*(=|\{))")
# A definition as clang-format writes it: it opens with `) {`, and what closes it stands below its
# first letter. Of a function, not of a statement in one.
OPENS = re.compile(r"( *)(?!if|for|while|switch|else|do|catch|namespace|struct|class|enum)\S.*\{")


def git(*command: str) -> str:
    """What git prints about this project."""
    return subprocess.run(
        ["git", "-C", str(ROOT), *command], check=True, capture_output=True, text=True
    ).stdout


def code_lines(text: str, python: bool) -> int:
    """Lines with code on them."""
    lexer = PythonLexer(stripnl=False) if python else CppLexer(stripnl=False)
    with_code, line = set(), 0
    for kind, value in lexer.get_tokens(text):
        apart = kind in Comment and kind not in Comment.Preproc and kind not in Comment.PreprocFile
        for k, part in enumerate(value.split("\n")):
            line += k > 0
            if part.strip() and not apart and kind not in String.Doc:
                with_code.add(line)
    return len(with_code)


def numbers(text: str) -> int:
    """Literals that are not PLAIN."""
    found = 0
    for kind, value in CppLexer().get_tokens(text):
        if kind in Number:
            digits = re.sub(r"['uUlLfF]+", "", value) if not value.startswith("0x") else value
            plain = re.fullmatch(r"[0-9.]+(e[+-]?[0-9]+)?", digits)
            found += not (plain and float(digits) in PLAIN)
    return found


def function_lengths(text: str, python: bool) -> Iterator[int]:
    """Lines of each function, from its first to its last."""
    if python:
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield (node.end_lineno or node.lineno) - node.lineno + 1
        return
    lines = text.split("\n")
    for begin, line in enumerate(lines):
        opens = OPENS.fullmatch(line)
        if not opens or ")" not in line or len(opens[1]) > 2:
            continue
        closes = opens[1] + "}"
        for end in range(begin + 1, len(lines)):
            if lines[end].startswith(closes):
                yield end - begin + 1
                break


def size(commit: str) -> dict[str, int]:
    """Each figure of a commit."""
    found: Counter[str] = Counter()
    for path in git("ls-tree", "-r", "--name-only", commit).splitlines():
        python = path.endswith(".py")
        kinds = [kind for kind, pattern in CODE.items() if pattern.fullmatch(path)]
        document = DOCUMENT.fullmatch(path) and path not in GENERATED
        if not kinds and not document:
            continue
        text = git("show", f"{commit}:{path}")
        if document:
            found["words of documents"] += len(text.split())
            continue
        found[kinds[0]] += code_lines(text, python)
        found["functions over 60 lines"] += sum(
            length > LONG for length in function_lengths(text, python)
        )
        if MODELS.fullmatch(path):
            found["named constants"] += len({match[0] for match in NAMED.finditer(text)})
            found["other numbers"] += numbers(text)
    found["code in all"] = sum(found[kind] for kind in CODE)
    return dict(found)


def main() -> int:
    """Prints a table."""
    parser = parser_of(__doc__)
    parser.add_argument("commit", nargs="*", default=["HEAD"], help="default: HEAD")
    args = parser.parse_args()
    try:
        commits = [git("rev-parse", "--short", commit).strip() for commit in args.commit]
    except subprocess.CalledProcessError as error:
        complain(error.stderr.strip())
        return 1
    sizes = {commit: size(commit) for commit in commits}
    names = dict.fromkeys(name for found in sizes.values() for name in found)
    rows = [{"": name} | {c: found.get(name, 0) for c, found in sizes.items()} for name in names]
    figures = [{"commit": commit} | found for commit, found in sizes.items()]
    print_figures(args, figures, table_of(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
