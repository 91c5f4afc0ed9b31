"""Reader of OBJ files and their material libraries for `compare_with_mitsuba.py`."""
import dataclasses
import pathlib

import numpy

# Albedo of materials without Kd, and of meshes without materials.
GREY = (0.8, 0.8, 0.8)


class Refused(Exception):
    """Content that the comparison does not support."""


@dataclasses.dataclass
class Material:
    """Albedo, alpha mask and emission. Glossy materials have a roughness, a metallicity and the reflectance of what is no metal."""
    albedo: list = GREY
    roughness: float | None = None
    metallic: float = 0.0
    reflectance: list = (0.04, 0.04, 0.04)
    mask: pathlib.Path | None = None
    cutoff: float = 0.5
    emission: list | None = None

    def f0(self):
        """Reflectance at normal incidence."""
        return [r + self.metallic * (a - r) for r, a in zip(self.reflectance, self.albedo)]


@dataclasses.dataclass
class Mesh:
    """Positions, normals and texture coordinates of vertices (the latter two may be missing); for each material its triangles."""
    positions: numpy.ndarray
    parts: list
    normals: numpy.ndarray | None = None
    uvs: numpy.ndarray | None = None


def read_obj(path, flat, materials_wanted):
    """Mesh of an OBJ file; without normals if `flat`."""
    if path.suffix.lower() != ".obj":
        raise Refused(f"[[mesh]] file {path} is no OBJ file")
    values = {"v": [], "vt": [], "vn": []}
    library, parts, corners, current = {}, {}, {}, None
    for number, line in enumerate(path.read_text().splitlines(), 1):
        word, *rest = line.split("#")[0].split() or [""]
        if word in values:
            values[word].append([float(value) for value in rest[:2 if word == "vt" else 3]])
        elif word == "mtllib" and materials_wanted:
            library.update(read_mtl(path.parent / " ".join(rest)))
        elif word == "usemtl":
            current = " ".join(rest)
        elif word == "f":
            ring = [corner_of(text, values, flat) for text in rest]
            if len(ring) > 3 and not is_convex([values["v"][corner[0]] for corner in ring]):
                raise Refused(f"{path}:{number}: the face is not convex; divide it into triangles")
            ring = [corners.setdefault(corner, len(corners)) for corner in ring]
            faces = parts.setdefault(current, [])
            faces += [(ring[0], ring[corner], ring[corner + 1]) for corner in range(1, len(ring) - 1)]
    taken = {}
    for place, word in enumerate(values):
        indices = [corner[place] for corner in corners]
        missing = [index is None for index in indices]
        if any(missing) and not all(missing):
            raise Refused(f"{path}: some corners have a {word} and others have not")
        taken[word] = None if all(missing) else numpy.array([values[word][index] for index in indices], numpy.float64)
    parts = [(library.get(name, Material()), faces) for name, faces in parts.items()]
    return Mesh(taken["v"], parts, taken["vn"], taken["vt"])


def corner_of(text, values, flat):
    """Indices of position, texture coordinates and normal of a face's corner."""
    indices = [int(index) if index else None for index in text.split("/")]
    indices += [None] * (3 - len(indices))
    if flat:
        indices[2] = None
    lengths = [len(values[word]) for word in ("v", "vt", "vn")]
    return tuple(None if index is None else index - 1 if index > 0 else length + index for index, length in zip(indices, lengths))


def is_convex(ring):
    """True if a polygon turns to one side at every corner."""
    points = numpy.array(ring)
    edges = numpy.roll(points, -1, 0) - points
    turns = numpy.cross(edges, numpy.roll(edges, -1, 0))
    return bool((turns @ turns.sum(0) >= 0).all())


def read_mtl(path):
    """Materials of a library by their names."""
    materials, name = {}, None
    for number, line in enumerate(path.read_text().splitlines(), 1):
        word, *rest = line.split("#")[0].split() or [""]
        word = word.lower()
        if word == "newmtl":
            name = " ".join(rest)
            materials[name] = Material()
        elif word in ("kd", "ke"):
            values = [float(value) for value in rest[:3]]
            values = values * 3 if len(values) == 1 else values
            if word == "kd":
                materials[name].albedo = [min(max(value, 0.0), 1.0) for value in values]
            elif any(values):
                materials[name].emission = values
        elif word == "map_d":
            materials[name].mask = path.parent / " ".join(rest)
        elif word in ("map_kd", "map_ke", "map_ks", "map_pr", "map_pm", "pr", "pm"):
            raise Refused(f"{path}:{number}: {word} is not supported; give the [[mesh]] an albedo or compare --layer irradiance")
    return materials
