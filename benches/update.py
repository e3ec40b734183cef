#!/usr/bin/env python3
"""Measures everything anew and writes the tables into docs/performance.md.

Usage: benches/update.py

Builds what it measures, and takes about five minutes. The text around
the tables, the date among it, stays. Standard library only.
"""

import re
import subprocess
from pathlib import Path

BENCHES = Path(__file__).resolve().parent
ROOT = BENCHES.parent
CARGO = ["cargo", "run", "--release", "--manifest-path", BENCHES / "Cargo.toml", "--", "--markdown"]
# What makes the tables between the marks of each name.
SOURCES = {
    "kernels": CARGO,
    "commands": [BENCHES / "commands.py", "--markdown"],
    "shortcuts": [BENCHES / "shortcuts.py", "--markdown"],
    "instructions": [BENCHES / "instructions.sh", "--record"],
}


def main():
    subprocess.run(["cargo", "build", "--release"], cwd=ROOT, check=True)
    ablation = ["--features", "ablation", "--target-dir", "target/ablation"]
    subprocess.run(["cargo", "build", "--release", *ablation], cwd=ROOT, check=True)
    document = ROOT / "docs" / "performance.md"
    for name, command in SOURCES.items():
        output = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
        block = f"<!-- {name} -->\n\n{fenced(name, output.rstrip())}\n\n<!-- end of {name} -->"
        pattern = f"<!-- {name} -->.*?<!-- end of {name} -->"
        text, count = re.subn(pattern, lambda _: block, document.read_text(), flags=re.DOTALL)
        if count != 1:
            raise SystemExit(f"{document}: the marks of {name} are not there once")
        document.write_text(text)


def fenced(name, output):
    """The output; what is no Markdown is indented as code."""
    if name != "instructions":
        return output
    return "\n".join("    " + line for line in output.splitlines())


if __name__ == "__main__":
    main()
