"""Checks that the folders of the sources stay small and that imports among them run one way.

    scripts/check_rooms.py [PACKAGE]

Any source, C++ or Python: at most 400 lines. The Python package: at most 20 modules in a folder,
and in each folder no cycle of imports among what lies in it (modules and subpackages). Prints what
it finds, one line each; exit code 1 where there is any. PACKAGE: only check this one (default:
scripts/gprodom and all sources). The folders of src/ are for scripts/check_includes.py.
"""

from __future__ import annotations

import argparse
import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[1]
MOST_MODULES = 20  # in a folder
MOST_LINES = 400  # of a source


# ---- any source ----


def too_long(sources: list[Path]) -> Iterator[str]:
    """Sources of more than `MOST_LINES` lines."""
    for path in sources:
        lines = path.read_text(encoding="utf-8").count("\n")
        if lines > MOST_LINES:
            yield f"{path}: {lines} lines, at most {MOST_LINES} are wanted"


def tracked_sources() -> list[Path]:
    """All sources that git knows or would add."""
    command = ["git", "-C", str(CHECKOUT), "ls-files", "--cached", "--others", "--exclude-standard"]
    said = subprocess.run([*command, "*.cpp", "*.h", "*.py"], capture_output=True, check=True)
    paths = [CHECKOUT / name for name in said.stdout.decode().split()]
    return [path for path in paths if path.is_file()]


# ---- the Python package ----


def find_modules(package: Path) -> dict[str, Path]:
    """The modules of a package by their full names; a package's own name is its __init__."""
    modules = {}
    for path in sorted(package.rglob("*.py")):
        parts = [package.name, *path.relative_to(package).with_suffix("").parts]
        modules[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return modules


def imports(module: str, path: Path, known: dict[str, Path]) -> set[str]:
    """The modules among `known` that `module` imports, anywhere in its text.

    A text that is the name of a module counts, as for `import_module`.
    """
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            parents = package.split(".")
            above = parents[: len(parents) - node.level + 1] if node.level else []
            base = ".".join([*above, node.module] if node.module else above)
            # A name imported from a package is a module of it, or something that its __init__ has.
            found |= {
                f"{base}.{alias.name}" if f"{base}.{alias.name}" in known else base
                for alias in node.names
            }
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "." in node.value:
            found.add(node.value)
    return (found & known.keys()) - {module}


def find_cycle(graph: dict[str, set[str]]) -> list[str]:
    """A cycle of the graph, its first node repeated at its end; empty where there is none."""
    done: set[str] = set()

    def follow(node: str, way: list[str]) -> list[str]:
        if node in way:
            return [*way[way.index(node) :], node]
        if node in done:
            return []
        for target in sorted(graph[node]):
            if cycle := follow(target, [*way, node]):
                return cycle
        done.add(node)
        return []

    return next((cycle for node in sorted(graph) if (cycle := follow(node, []))), [])


def python_faults(package: Path) -> Iterator[str]:
    """What is wrong with the folders of a Python package."""
    modules = find_modules(package)
    edges = [
        (module, target)
        for module, path in modules.items()
        for target in imports(module, path, modules)
    ]
    for folder in sorted({path.parent for path in modules.values()}):
        name = ".".join([package.name, *folder.relative_to(package).parts])
        count = len(list(folder.glob("*.py")))
        if count > MOST_MODULES:
            yield f"{folder}: {count} modules, at most {MOST_MODULES} are wanted"

        # A module's node is what lies directly in this folder and holds it; "" is its __init__.
        nodes = {
            module: module.removeprefix(name).removeprefix(".").partition(".")[0]
            for module in modules
            if f"{module}.".startswith(f"{name}.")
        }
        graph: dict[str, set[str]] = {node: set() for node in nodes.values()}
        for module, target in edges:
            if module in nodes and target in nodes and nodes[module] != nodes[target]:
                graph[nodes[module]].add(nodes[target])
        if cycle := find_cycle(graph):
            yield f"{folder}: imports go round: {' -> '.join(node or '__init__' for node in cycle)}"


def main() -> int:
    """Prints the faults; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("package", type=Path, nargs="?")
    args = parser.parse_args()
    sources = list(args.package.rglob("*.py")) if args.package else tracked_sources()
    faults = list(python_faults(args.package or CHECKOUT / "scripts" / "gprodom"))
    faults += too_long(sources)
    print("\n".join(faults) or "folders and imports are as wanted")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
