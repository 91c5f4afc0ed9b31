#!/usr/bin/env python3
"""Compares default frames of two versions of the program: visible errors and time.

  python3 scripts/compare_programs.py --before OLD --after NEW --commits 657aac6 1234567 atrium toys scene.toml > rows.csv

OLD and NEW are two builds of `halflight`. Each renders each scene, in turn, --rounds times; times are medians of whole frames, as the
statistics tell them. Errors are of the irradiance at pixels' centres against NEW's reference of --samples samples a pixel. Versions before smooth
shading are held against a reference of the scene with `smooth = "off"`, so that facets do not count as noise (--flat-before). With --pictures DIR,
the pictures of both and of the reference are kept. Scenes are names of bundled ones or files.
"""
import argparse
import csv
import json
import pathlib
import platform
import re
import shlex
import statistics
import subprocess
import sys
import tempfile

COLUMNS = ["scene", "version", "options", "width", "height", "time_ms", "nmse2", "flip_p99", "grain", "commit", "machine"]


def arguments():
    """Options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", help="bundled scenes or scene files")
    parser.add_argument("--before", type=pathlib.Path, required=True, help="older program")
    parser.add_argument("--after", type=pathlib.Path, required=True, help="newer program")
    parser.add_argument("--before-options", default="", help="options of the older one, in one argument")
    parser.add_argument("--after-options", default="", help="options of the newer one, in one argument")
    parser.add_argument("--commits", nargs=2, required=True, metavar=("BEFORE", "AFTER"), help="commits that the programs were built from")
    parser.add_argument("--flat-before", action="store_true", help="hold the older one against flat surfaces")
    parser.add_argument("--size", default="640x480", help="size of the images [default: 640x480]")
    parser.add_argument("--samples", type=int, default=4096, help="samples a pixel of the references [default: 4096]")
    parser.add_argument("--rounds", type=int, default=5, help="frames of each program [default: 5]")
    parser.add_argument("--machine", default=f"{platform.machine()}, {platform.system().lower()}", help="machine, as rows name it")
    parser.add_argument("--pictures", type=pathlib.Path, help="folder for pictures")
    return parser.parse_args()


def run(*command):
    """Runs a program and returns what it wrote to standard output."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr.strip()}")
    return done.stdout


def flat(program, scene, folder):
    """Scene file in which no mesh is smooth, beside the original, so that its relative paths hold."""
    path = pathlib.Path(scene)
    bundled = pathlib.Path(__file__).parent.parent / "crates/halflight-scene/scenes" / f"{scene}.toml"
    path = path if path.suffix == ".toml" else bundled
    text = re.sub(r"^smooth *=.*$", "", path.read_text(), flags=re.M)
    out = folder / path.name
    text = re.sub(r'^(\s*file *= *)"([^/"][^"]*)"', lambda m: f'{m[1]}"{(path.parent / m[2]).resolve()}"', text, flags=re.M)
    out.write_text(text.replace("[[mesh]]", '[[mesh]]\nsmooth = "off"'))
    return out


def main():
    """Prints rows of CSV for all scenes."""
    options = arguments()
    rows = csv.DictWriter(sys.stdout, COLUMNS, lineterminator="\n")
    rows.writeheader()
    width, height = options.size.split("x")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for scene in options.scenes:
            name = pathlib.Path(scene).stem
            truths = [folder / "flat.exr", folder / "smooth.exr"]
            sources = [flat(options.after, scene, folder) if options.flat_before else scene, scene]
            for source, truth in zip(sources, truths):
                run(options.after, "reference", source, "--size", options.size, "--samples", options.samples, "--out", truth, "--cache", folder / truth.stem)
            programs = [(options.before, options.before_options), (options.after, options.after_options)]
            times = [[], []]
            for _ in range(options.rounds):
                for index, (program, choices) in enumerate(programs):
                    stats, image = folder / "stats.json", folder / f"{index}.exr"
                    run(program, "render", scene, "--size", options.size, *shlex.split(choices), "--out", image, "--stats", stats)
                    times[index].append(json.loads(stats.read_text())["total_ms"])
            for index, (version, commit) in enumerate(zip(["before", "after"], options.commits)):
                measured = json.loads(run(options.after, "compare", folder / f"{index}.exr", truths[index], "--layer", "irradiance", "--json"))
                rows.writerow({
                    "scene": name, "version": version, "options": programs[index][1], "width": width, "height": height,
                    "time_ms": f"{statistics.median(times[index]):.1f}", "nmse2": f"{measured['nmse2']:.3e}",
                    "flip_p99": f"{measured['flip_p99']:.4f}", "grain": f"{measured['grain']:.4f}", "commit": commit, "machine": options.machine,
                })
            sys.stdout.flush()
            if options.pictures:
                options.pictures.mkdir(parents=True, exist_ok=True)
                for index, (program, choices) in enumerate(programs):
                    run(program, "render", scene, "--size", options.size, *shlex.split(choices), "--png", options.pictures / f"{name}-{['before', 'after'][index]}.png")
                run(options.after, "render", scene, "--size", options.size, "--refiner", "per-pixel", "--samples", "4096", "--antialias", "8",
                    "--png", options.pictures / f"{name}-reference.png")
            for state in folder.iterdir():
                run("rm", "-rf", state)


main()
