#!/usr/bin/env python3
"""Flicker of edges while the camera turns by parts of a pixel a frame, with and without antialiasing.

  python3 scripts/flicker_of_edges.py --program target/release/halflight --commit 1234567 atrium toys > rows.csv

The camera turns by --step pixels a frame to the right and half as much upwards. The flicker between two frames is the change of the radiance's
luminance that the reference does not have, |change of the image - change of the reference|, over the reference's mean: its mean and 99th
percentile over all pixels and frames. The reference has rays of its own for 16 sub-samples of every pixel. Needs Python 3.11, numpy and OpenEXR
(python3 -m pip install numpy OpenEXR).
"""
import argparse
import csv
import math
import pathlib
import platform
import re
import subprocess
import sys
import tempfile
import tomllib

import numpy
import OpenEXR


def arguments():
    """Options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", help="bundled scenes or scene files")
    parser.add_argument("--program", type=pathlib.Path, required=True, help="halflight")
    parser.add_argument("--commit", required=True, help="commit that it was built from")
    parser.add_argument("--size", default="320x240", help="size of the images [default: 320x240]")
    parser.add_argument("--frames", type=int, default=9, help="frames [default: 9]")
    parser.add_argument("--step", type=float, default=0.25, help="pixels a frame [default: 0.25]")
    parser.add_argument("--samples", type=int, default=2048, help="samples a pixel of the reference [default: 2048]")
    parser.add_argument("--machine", default=f"{platform.machine()}, {platform.system().lower()}", help="machine, as rows name it")
    return parser.parse_args()


def run(*command):
    """Runs a program that must succeed."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr.strip()}")


def turned(scene, pixels, height, folder):
    """Scene file whose camera is turned by a number of pixels to the right and half as many upwards."""
    path = pathlib.Path(scene)
    if path.suffix != ".toml":
        path = pathlib.Path(__file__).parent.parent / "crates/halflight-scene/scenes" / f"{scene}.toml"
    text = path.read_text()
    camera = tomllib.loads(text)["camera"]
    eye, target = numpy.array(camera["eye"], float), numpy.array(camera["target"], float)
    up = numpy.array(camera.get("up", [0, 1, 0]), float)
    forward = target - eye
    right = numpy.cross(forward, up)
    right /= numpy.linalg.norm(right)
    above = numpy.cross(right, forward)
    above /= numpy.linalg.norm(above)
    pixel = 2 * math.tan(math.radians(camera["fov_y_deg"]) / 2) / height * numpy.linalg.norm(forward)
    target = target + (right + above / 2) * pixels * pixel
    text = re.sub(r"^target *=.*$", f"target = [{target[0]:.9f}, {target[1]:.9f}, {target[2]:.9f}]", text, count=1, flags=re.M)
    text = re.sub(r'^(\s*file *= *)"([^/"][^"]*)"', lambda m: f'{m[1]}"{(path.parent / m[2]).resolve()}"', text, flags=re.M)
    out = folder / path.name
    out.write_text(text)
    return out


def luminance(path):
    """Luminance of the radiance of an OpenEXR file, height by width."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return sum(weight * channels[name].pixels.astype(float) for name, weight in (("R", 0.2126), ("G", 0.7152), ("B", 0.0722)))


def main():
    """Prints rows of CSV for all scenes."""
    options = arguments()
    rows = csv.writer(sys.stdout, lineterminator="\n")
    rows.writerow(["scene", "width", "height", "antialias", "step_px", "frames", "flicker_mean", "flicker_p99", "commit", "machine"])
    width, height = map(int, options.size.split("x"))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for scene in options.scenes:
            last, changes, scales = {}, {1: [], 8: []}, []
            for frame in range(options.frames):
                file, truth, image = turned(scene, frame * options.step, height, folder), folder / f"truth-{frame}.exr", folder / "image.exr"
                run(options.program, "reference", file, "--size", options.size, "--samples", options.samples, "--antialias", 16, "--out", truth, "--cache", folder / f"state-{frame}")
                reference = luminance(truth)
                scales.append(reference.mean())
                for antialias in changes:
                    run(options.program, "render", file, "--size", options.size, "--quality", "good", "--antialias", antialias, "--out", image)
                    error = luminance(image) - reference
                    if antialias in last:
                        changes[antialias].append(numpy.abs(error - last[antialias]))
                    last[antialias] = error
            for antialias, flicker in changes.items():
                flicker = numpy.concatenate([change.ravel() for change in flicker]) / numpy.mean(scales)
                rows.writerow([pathlib.Path(scene).stem, width, height, antialias, options.step, options.frames, f"{flicker.mean():.3e}", f"{numpy.percentile(flicker, 99):.4f}", options.commit, options.machine])
            sys.stdout.flush()
            for path in sorted(folder.rglob("*"), reverse=True):
                path.rmdir() if path.is_dir() else path.unlink()


main()
