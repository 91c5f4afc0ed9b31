#!/usr/bin/env python3
"""Renders the scenes of `scripts/scenes`, compares them with Mitsuba and writes the rows of `results/mitsuba/comparison.csv`.

  python3 scripts/mitsuba_table.py target/debug/halflight
  python3 scripts/mitsuba_table.py target/debug/halflight --indirect      writes results/mitsuba/indirect.csv

Rows with a change are controls: Mitsuba's scene differs in that one value, and the comparison must find far more than the row of the same
scene without it. Refuses to run on a working tree that differs from its commit. Needs what compare_with_mitsuba.py needs.
"""
import argparse
import csv
import os
import pathlib
import platform
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLE = ROOT / "results/mitsuba/comparison.csv"
INDIRECT_TABLE = ROOT / "results/mitsuba/indirect.csv"

# Scene, size, Mitsuba's samples a pixel, and changes that must be found.
ROWS = [
    ("disk", "160x120", 1024, ["light.0.radius=0.62"]),
    ("hexagon", "160x120", 1024, ["light.0.radiance=[31, 29, 27]"]),
    ("screen", "160x120", 1024, ["mesh.0.transform.rotate_deg=[0, 28, 0]"]),
    ("plate", "160x120", 1024, ["light.0.axis_v=[0.2, 0, 0.38]"]),
    ("sphere", "160x120", 1024, ["light.0.radius=0.36"]),
    ("metal-0.6", "160x120", 1024, ["mesh.0.roughness=0.62"]),
    ("metal-0.3", "160x120", 1024, []),
    ("metal-0.2", "160x120", 1024, []),
    ("leaves", "96x72", 1024, ["mesh.0.alpha_cutoff=0.49", "mesh.0.transform.translate=[0.03, 0, 0]"]),
    ("lamps", "160x120", 1024, ["mesh.0.transform.translate=[0, 0.03, 0]"]),
    ("smooth-ball", "160x120", 1024, ['mesh.1.smooth="off"']),
    ("plastic", "96x72", 8192, ["mesh.0.roughness=0.42", "mesh.0.reflectance=[0.06, 0.06, 0.06]"]),
]

# The same for references of one diffuse reflection.
INDIRECT_ROWS = [
    ("corner", "64x48", 1024, ["light.0.radius=0.52", "mesh.0.albedo=[0.7, 0.7, 0.7]"]),
    ("disk", "64x48", 1024, ["light.0.radius=0.62"]),
    ("corner-screen", "64x48", 1024, ["light.0.corner=[-0.9, 2.9, -0.5]"]),
]

# Rays of each pixel of these references.
RAYS = 8192

COLUMNS = ["scene", "change", "width", "height", "quality", "mitsuba_samples", "nmse2", "mitsuba_noise", "ratio_of_means", "command", "commit",
           "machine"]


def run(command):
    """Standard output of a command that must succeed."""
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def machine():
    """Processor, cores and system."""
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines() if pathlib.Path("/proc/cpuinfo").exists() else []
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{models[0] if models else platform.processor()}, {os.cpu_count()} cores, {platform.system().lower()}"


def rows(halflight, folder, indirect):
    """Rows of the table, one after another."""
    commit, place = run(["git", "rev-parse", "--short", "HEAD"]).strip(), machine()
    quality = f"{RAYS} rays" if indirect else "final"
    for scene, size, samples, changes in INDIRECT_ROWS if indirect else ROWS:
        path = f"scripts/scenes/{scene}.toml"
        render = ["render", path, "--size", size, "--quality", "final", "--antialias", "1", "--out"]
        if indirect:
            render = ["reference", path, "--indirect", "--size", size, "--samples", str(RAYS), "--out"]
        image = folder / "image.exr"
        run([halflight, *render, str(image)])
        for change in [None, *changes]:
            compare = ["scripts/compare_with_mitsuba.py", path, "image.exr", "--samples", str(samples)]
            compare += ["--layer", "indirect"] if indirect else []
            if change:
                compare += ["--change", f"'{change}'"]
            arguments = [str(image) if word == "image.exr" else word.strip("'") for word in compare]
            text = run([sys.executable, *arguments])
            values = [re.search(rf"^{name} +(\S+)", text, re.MULTILINE).group(1) for name in ("NMSE2", "of which noise", "ratio of means")]
            command = f"halflight {' '.join(render)} image.exr; python3 {' '.join(compare)}"
            yield [scene, change or "", *size.split("x"), quality, samples, *values, command, commit, place]
            print(scene, change or "", *values, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("halflight", type=lambda path: str(pathlib.Path(path).resolve()), help="the program")
    parser.add_argument("--indirect", action="store_true", help="compare references of indirect light")
    options = parser.parse_args()
    if run(["git", "status", "--porcelain", "--untracked-files=no"]).strip():
        sys.exit("error: the working tree differs from its commit, which the rows would name; commit first")
    with tempfile.TemporaryDirectory() as folder:
        found = list(rows(options.halflight, pathlib.Path(folder), options.indirect))
    with (INDIRECT_TABLE if options.indirect else TABLE).open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *found])


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as fault:
        sys.exit(f"error: {' '.join(fault.cmd)}\n{fault.stderr}")
