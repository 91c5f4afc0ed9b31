"""Reader of the scene files that `compare_with_mitsuba.py` compares: camera, lights and triangles in world space."""
import dataclasses
import pathlib
import tomllib

import numpy

# Albedo of materials without Kd, and of meshes without materials.
GREY = (0.8, 0.8, 0.8)


class Refused(Exception):
    """Content that the comparison does not support."""


@dataclasses.dataclass
class Camera:
    """Pinhole camera; angle of view in degrees from bottom to top."""
    eye: numpy.ndarray
    target: numpy.ndarray
    up: numpy.ndarray
    fov_y_deg: float

    def rays(self, width, height):
        """Origin and unit directions of the rays through pixel centres, rows from the top."""
        forward = self.target - self.eye
        forward = forward / numpy.linalg.norm(forward)
        right = numpy.cross(forward, self.up)
        right /= numpy.linalg.norm(right)
        tangent = numpy.tan(numpy.radians(self.fov_y_deg) / 2)
        x = (2 * (numpy.arange(width) + 0.5) / width - 1) * tangent * width / height
        y = (1 - 2 * (numpy.arange(height) + 0.5) / height) * tangent
        directions = forward + x[None, :, None] * right + y[:, None, None] * numpy.cross(right, forward)
        return self.eye, directions / numpy.linalg.norm(directions, axis=2, keepdims=True)


@dataclasses.dataclass
class Light:
    """One-sided light. `u` and `v` run from the centre to the edges of a parallelogram or along the axes of an ellipse, and the light emits
    along their cross product; polygons emit to where their points run counterclockwise. Spheres have a centre and a radius."""
    shape: str
    radiance: list
    centre: numpy.ndarray = None
    u: numpy.ndarray = None
    v: numpy.ndarray = None
    points: list = None
    radius: float = None
    texture: pathlib.Path = None
    encoding: str = "auto"
    transposed: bool = False

    def reversed(self):
        """Light that emits from the other side; every point keeps its radiance."""
        if self.shape == "polygon":
            return dataclasses.replace(self, points=self.points[::-1])
        return dataclasses.replace(self, u=self.v, v=self.u, transposed=not self.transposed)


@dataclasses.dataclass
class Mesh:
    """Positions, and for each material its albedo and triangles; of metal, its roughness."""
    positions: numpy.ndarray
    parts: list
    metal: float | None = None


@dataclasses.dataclass
class Scene:
    camera: Camera
    lights: list
    meshes: list


# Keys of specular reflection.
SPECULAR = ["specular", "roughness", "metallic", "reflectance"]


def only(table, name, known):
    """Refuses keys that are not known."""
    for key in table:
        if key not in known:
            raise Refused(f"{name} has `{key}`, which is not supported here; supported: {', '.join(known)}")


def vector(value):
    return numpy.array(value, numpy.float64)


def read(path):
    """Scene of a file."""
    table = tomllib.loads(path.read_text())
    only(table, str(path), ["description", "camera", "light", "mesh"])
    camera = table["camera"]
    camera = Camera(vector(camera["eye"]), vector(camera["target"]), vector(camera.get("up", [0, 1, 0])), camera["fov_y_deg"])
    lights = []
    for entry in table.get("light", []):
        light = read_light(entry, path.parent)
        lights += [light, light.reversed()] if entry.get("two_sided") else [light]
    if not lights:
        raise Refused(f"{path} has no [[light]]")
    return Scene(camera, lights, [read_mesh(entry, path.parent) for entry in table["mesh"]])


def principal_axes(u, v):
    """Perpendicular axes of an ellipse with the conjugate ones `u` and `v`, and the same cross product."""
    left, lengths, _ = numpy.linalg.svd(numpy.stack([u, v], 1), full_matrices=False)
    a, b = left[:, 0] * lengths[0], left[:, 1] * lengths[1]
    return (a, b) if numpy.cross(a, b) @ numpy.cross(u, v) > 0 else (b, a)


def read_light(entry, folder):
    """One side of a `[[light]]`."""
    shape = entry.get("shape", "parallelogram")
    keys = {"parallelogram": ["corner", "edge_u", "edge_v", "texture", "texture_encoding", "texture_stretch"],
            "disk": ["centre", "normal", "radius"], "ellipse": ["centre", "axis_u", "axis_v"], "polygon": ["points"],
            "sphere": ["centre", "radius"]}
    if shape not in keys:
        raise Refused(f"[[light]] has the shape `{shape}`, expected one of {', '.join(keys)}")
    sides = [] if shape == "sphere" else ["two_sided"]
    only(entry, f"[[light]] of shape {shape}", ["shape", "radiance", *sides, *keys[shape]])
    radiance = entry["radiance"]
    if shape == "sphere":
        return Light(shape, radiance, vector(entry["centre"]), radius=entry["radius"])
    if shape == "polygon":
        return Light(shape, radiance, points=[vector(point) for point in entry["points"]])
    if shape == "parallelogram":
        u, v = vector(entry["edge_u"]) / 2, vector(entry["edge_v"]) / 2
        name = entry.get("texture")
        if name and "#" in name:
            raise Refused(f"[[light]] has the video `{name}`; name one of its frames")
        return Light(shape, radiance, vector(entry["corner"]) + u + v, u, v, texture=folder / name if name else None,
                     encoding=entry.get("texture_encoding", "auto"))
    if shape == "ellipse":
        u, v = principal_axes(vector(entry["axis_u"]), vector(entry["axis_v"]))
        return Light(shape, radiance, vector(entry["centre"]), u, v)
    normal = vector(entry["normal"])
    normal /= numpy.linalg.norm(normal)
    u = numpy.cross(normal, numpy.eye(3)[numpy.abs(normal).argmin()])
    u *= entry["radius"] / numpy.linalg.norm(u)
    return Light(shape, radiance, vector(entry["centre"]), u, numpy.cross(normal, u))


def transformed(positions, transform):
    """Positions after scale, then rotation about x, y and z, then translation."""
    only(transform, "transform", ["translate", "rotate_deg", "scale"])
    positions = positions * vector(transform.get("scale", 1))
    for axis, degrees in enumerate(transform.get("rotate_deg", [0, 0, 0])):
        sine, cosine = numpy.sin(numpy.radians(degrees)), numpy.cos(numpy.radians(degrees))
        b, c = (axis + 1) % 3, (axis + 2) % 3
        turned = positions.copy()
        turned[:, b] = cosine * positions[:, b] - sine * positions[:, c]
        turned[:, c] = sine * positions[:, b] + cosine * positions[:, c]
        positions = turned
    return positions + vector(transform.get("translate", 0))


def read_mesh(entry, folder):
    """Mesh of a `[[mesh]]`."""
    if "generator" in entry:
        positions, parts = generated(entry)
    else:
        only(entry, "[[mesh]]", ["file", "transform", "albedo", "smooth", "crease_deg", "emissive", *SPECULAR])
        if entry.get("smooth") == "on":
            raise Refused(f"[[mesh]] {entry['file']} is smooth, expected smooth = \"off\"")
        if entry.get("emissive") == "lights":
            raise Refused(f"[[mesh]] {entry['file']} makes lights of emissive faces; write them as [[light]]")
        positions, parts = read_obj(folder / entry["file"], entry.get("smooth") == "off", "albedo" not in entry)
    if "albedo" in entry:
        parts = [(entry["albedo"], [face for _, faces in parts for face in faces])]
    positions = transformed(numpy.array(positions, numpy.float64), entry.get("transform", {}))
    return Mesh(positions, parts, metal(entry))


def metal(entry):
    """Roughness of a `[[mesh]]` of metal; none of a matte one. Others are refused: Mitsuba has no surface that adds both lobes as halflight does."""
    if not any(key in entry for key in ("roughness", "metallic", "reflectance")):
        return None
    if entry.get("metallic") != 1:
        raise Refused("[[mesh]] reflects specularly and is no metal, expected metallic = 1 or a matte surface")
    return entry.get("roughness", 0.5)


def read_obj(path, flat, colours):
    """Positions of an OBJ file, and the albedo and triangles of each of its materials."""
    if path.suffix.lower() != ".obj":
        raise Refused(f"[[mesh]] file {path} is no OBJ file")
    positions, materials, parts, current = [], {}, {}, None
    for number, line in enumerate(path.read_text().splitlines(), 1):
        word, *rest = line.split("#")[0].split() or [""]
        if word == "v":
            positions.append([float(value) for value in rest[:3]])
        elif word == "vn" and not flat:
            raise Refused(f"{path}:{number}: has normals, which the comparison does not shade by; write smooth = \"off\" in the [[mesh]]")
        elif word == "mtllib" and colours:
            materials.update(read_mtl(path.parent / " ".join(rest)))
        elif word == "usemtl":
            current = " ".join(rest)
        elif word == "f":
            ring = [int(corner.split("/")[0]) for corner in rest]
            ring = [index - 1 if index > 0 else len(positions) + index for index in ring]
            if len(ring) > 3 and not is_convex([positions[index] for index in ring]):
                raise Refused(f"{path}:{number}: the face is not convex; divide it into triangles")
            faces = parts.setdefault(current, [])
            faces += [(ring[0], ring[corner], ring[corner + 1]) for corner in range(1, len(ring) - 1)]
    return positions, [(materials.get(name, GREY), faces) for name, faces in parts.items()]


def is_convex(ring):
    """True if a polygon turns to one side at every corner."""
    points = numpy.array(ring)
    edges = numpy.roll(points, -1, 0) - points
    turns = numpy.cross(edges, numpy.roll(edges, -1, 0))
    return bool((turns @ turns.sum(0) >= 0).all())


def read_mtl(path):
    """Albedo of each material of a library."""
    albedo, name = {}, None
    for number, line in enumerate(path.read_text().splitlines(), 1):
        word, *rest = line.split("#")[0].split() or [""]
        word = word.lower()
        if word == "newmtl":
            name = " ".join(rest)
            albedo[name] = GREY
        elif word == "kd":
            values = [min(max(float(value), 0.0), 1.0) for value in rest[:3]]
            albedo[name] = values * 3 if len(values) == 1 else values
        elif word in ("map_kd", "map_d", "map_ks"):
            raise Refused(f"{path}:{number}: {word} is not supported; give the [[mesh]] an albedo or compare --layer irradiance")
    return albedo


def generated(entry):
    """Positions and parts of a generator that is simple enough."""
    name = entry["generator"]
    own = {"open-floor": [], "contact": ["width", "height", "depth"]}
    if name not in own:
        raise Refused(f"[[mesh]] has the generator `{name}`, expected one of {', '.join(own)} or an OBJ file")
    only(entry, f"[[mesh]] generator {name}", ["generator", "transform", "albedo", "smooth", "size", "cells", *SPECULAR, *own[name]])
    half = entry.get("size", 20.0) / 2
    positions = [[-half, 0, -half], [-half, 0, half], [half, 0, half], [half, 0, -half]]
    parts = [((0.75, 0.75, 0.75), [(0, 1, 2), (0, 2, 3)])]
    if name == "contact":
        width, height, depth = (entry.get(key, 1.0) for key in ("width", "height", "depth"))
        # The box reaches into the floor by a hundredth of its height.
        corners = [(x * width / 2, y, z * depth / 2) for y in (-0.01 * height, height) for x, z in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
        positions += [list(corner) for corner in corners]
        quads = [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
        faces = [tuple(4 + quad[corner] for corner in corners) for quad in quads for corners in ((0, 1, 2), (0, 2, 3))]
        parts.append(((0.7, 0.45, 0.3), faces))
    return positions, parts
