"""Runs the Python of docs/guide.md where its commands have run: guide_snippets.py PROGRAM

Needs mitsuba, pyradiance, xarray with h5netcdf or netCDF4, numpy and pandas."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

PROGRAM = Path(sys.argv[1]).resolve()
HOME = Path(__file__).resolve().parents[2]
WRITTEN = ["beads-ball.png", "panel.oct"]


def blocks(text):
    """Marks and texts of the fenced blocks, in order."""
    lines = iter(text.splitlines())
    for line in lines:
        if line.startswith("```"):
            body = []
            for inner in lines:
                if inner == "```":
                    break
                body.append(inner)
            yield line[3:].strip(), "\n".join(body) + "\n"


def run(command, place, environment):
    done = subprocess.run(command, cwd=place, env=environment, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"FAILED {command[-1]}\n{done.stdout}{done.stderr}")
    return done.stdout


def main():
    environment = os.environ | {"PATH": f"{PROGRAM.parent}:{os.environ['PATH']}"}
    with tempfile.TemporaryDirectory() as name:
        place, count = Path(name), 0
        (place / "assets").symlink_to(HOME / "assets")
        for mark, text in blocks((HOME / "docs/guide.md").read_text()):
            if " " in mark:
                (place / mark.split()[1]).write_text(text)
        for mark, text in blocks((HOME / "docs/guide.md").read_text()):
            if mark == "sh":
                run(["sh", "-e", "-c", text], place, environment)
            elif mark == "python":
                count += 1
                print(f"ok     snippet {count}:", run([sys.executable, "-c", text], place, environment), sep="\n")
        assert count > 4, count
        for file in WRITTEN:
            assert (place / file).stat().st_size > 0, file


main()
