"""Reader of the scene files that `compare_with_mitsuba.py` compares: camera, lights and triangles in world space."""
import dataclasses
import pathlib
import tomllib

import numpy

from obj_file import Material, Mesh, Refused, read_obj


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
    """One-sided light; emissive faces of a mesh have the numbers of the mesh and of the part. `u` and `v` run from the centre to the edges of a parallelogram or along the axes of an ellipse, and the light emits
    along their cross product; polygons emit to where their points run counterclockwise. Spheres have a centre and a radius."""
    shape: str
    radiance: list
    centre: numpy.ndarray = None
    u: numpy.ndarray = None
    v: numpy.ndarray = None
    points: list = None
    radius: float = None
    part: tuple = None
    texture: pathlib.Path = None
    encoding: str = "auto"
    transposed: bool = False

    def reversed(self):
        """Light that emits from the other side; every point keeps its radiance."""
        if self.shape == "polygon":
            return dataclasses.replace(self, points=self.points[::-1])
        return dataclasses.replace(self, u=self.v, v=self.u, transposed=not self.transposed)


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


def read(path, changes=()):
    """Scene of a file. `changes` replace values of it: keys such as `light.0.radius`, and values as in a scene file."""
    table = tomllib.loads(path.read_text())
    for key, value in changes:
        change(table, key, value)
    only(table, str(path), ["description", "camera", "light", "mesh"])
    camera = table["camera"]
    camera = Camera(vector(camera["eye"]), vector(camera["target"]), vector(camera.get("up", [0, 1, 0])), camera["fov_y_deg"])
    lights = []
    for entry in table.get("light", []):
        light = read_light(entry, path.parent)
        lights += [light, light.reversed()] if entry.get("two_sided") else [light]
    meshes = [read_mesh(entry, path.parent) for entry in table["mesh"]]
    for number, (entry, mesh) in enumerate(zip(table["mesh"], meshes)):
        for part, (material, _) in enumerate(mesh.parts):
            if material.emission and entry.get("emissive") == "lights":
                lights.append(Light("faces", material.emission, part=(number, part)))
    if not lights:
        raise Refused(f"{path} has no [[light]]")
    return Scene(camera, lights, meshes)


def change(table, key, value):
    """Replaces or adds one value of a scene file."""
    *path, last = key.split(".")
    try:
        for name in path:
            table = table[int(name)] if isinstance(table, list) else table.setdefault(name, {})
        table[last] = tomllib.loads(f"value = {value}")["value"]
    except (AttributeError, IndexError, TypeError, ValueError) as fault:
        raise Refused(f"the scene file has no place for {key} = {value}: {fault}") from fault


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
    transform = entry.get("transform", {})
    if "generator" in entry:
        mesh = generated(entry)
    else:
        only(entry, "[[mesh]]", ["file", "transform", "albedo", "smooth", "crease_deg", "emissive", "alpha_cutoff", *SPECULAR])
        mesh = read_obj(folder / entry["file"], entry.get("smooth") == "off", "albedo" not in entry)
        if entry.get("smooth") == "on" and mesh.normals is None:
            raise Refused(f"[[mesh]] {entry['file']} has no normals, expected smooth = \"off\" or normals in the file")
    if mesh.normals is not None and transform.keys() - {"translate", "rotate_deg"}:
        raise Refused(f"[[mesh]] {entry['file']} has normals and a scale; write smooth = \"off\" or remove the scale")
    if "albedo" in entry:
        mesh.parts = [(Material(entry["albedo"]), [face for _, faces in mesh.parts for face in faces])]
    mesh.positions = transformed(numpy.array(mesh.positions, numpy.float64), transform)
    if mesh.normals is not None:
        mesh.normals = transformed(mesh.normals, {"rotate_deg": transform.get("rotate_deg", [0, 0, 0])})
    for material, _ in mesh.parts:
        material.cutoff = entry.get("alpha_cutoff", 0.5)
        if entry.get("specular") != "off" and any(key in entry for key in ("roughness", "metallic", "reflectance")):
            material.roughness, material.metallic = entry.get("roughness", 0.5), entry.get("metallic", 0.0)
            material.reflectance = entry.get("reflectance", material.reflectance)
    return mesh


def generated(entry):
    """Mesh of a generator that is simple enough."""
    name = entry["generator"]
    own = {"open-floor": [], "contact": ["width", "height", "depth"]}
    if name not in own:
        raise Refused(f"[[mesh]] has the generator `{name}`, expected one of {', '.join(own)} or an OBJ file")
    only(entry, f"[[mesh]] generator {name}", ["generator", "transform", "albedo", "smooth", "size", "cells", *SPECULAR, *own[name]])
    half = entry.get("size", 20.0) / 2
    positions = [[-half, 0, -half], [-half, 0, half], [half, 0, half], [half, 0, -half]]
    parts = [(Material((0.75, 0.75, 0.75)), [(0, 1, 2), (0, 2, 3)])]
    if name == "contact":
        width, height, depth = (entry.get(key, 1.0) for key in ("width", "height", "depth"))
        # The box reaches into the floor by a hundredth of its height.
        corners = [(x * width / 2, y, z * depth / 2) for y in (-0.01 * height, height) for x, z in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
        positions += [list(corner) for corner in corners]
        quads = [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
        faces = [tuple(4 + quad[corner] for corner in corners) for quad in quads for corners in ((0, 1, 2), (0, 2, 3))]
        parts.append((Material((0.7, 0.45, 0.3)), faces))
    return Mesh(positions, parts)
