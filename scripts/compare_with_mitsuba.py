#!/usr/bin/env python3
"""Compares an image of `halflight render` with the direct or indirect light that Mitsuba 3 computes for the same scene.

  halflight render scene.toml --size 160x120 --quality final --antialias 1 --out image.exr
  python3 scripts/compare_with_mitsuba.py scene.toml image.exr --samples 1024

With --layer indirect the image is the layer `indirect` of `halflight reference --indirect` or `halflight render --indirect`, and Mitsuba's is the
light of exactly one diffuse reflection: its path tracer of depth 3 less that of depth 2, with equal random numbers.

Both sides take rays through pixel centres. Mitsuba's image is the mean of two renders with seeds of their own; their difference is its
noise. Printed are the NMSE2 of halflight's image against that mean, the part of it that is Mitsuba's noise, and the ratio of the means.

Read are scene files with OBJ meshes, the generators open-floor and contact, and lights of every shape (docs/mitsuba.md). Anything else that
would change the image is refused by name. Needs Python 3.11, numpy and mitsuba (python3 -m pip install numpy mitsuba); the variant
scalar_rgb needs no LLVM.
"""
import argparse
import pathlib
import sys

import scene_file
import surfaces
from obj_file import Mesh, Refused


def arguments():
    """Options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path, help="scene file")
    parser.add_argument("image", type=pathlib.Path, help="OpenEXR file of halflight render")
    parser.add_argument("--samples", type=int, default=1024, help="light samples a pixel of each of the two renders, or paths for indirect light [default: 1024]")
    parser.add_argument("--layer", choices=["radiance", "irradiance", "indirect"], default="radiance",
                        help="quantity: R, G, B with materials, irradiance without, or radiance of indirect light [default: radiance]")
    parser.add_argument("--conductor", type=float, nargs=2, metavar=("F0", "ROUGHNESS"),
                        help="make all surfaces rough conductors of this reflectance at normal incidence")
    parser.add_argument("--change", action="append", default=[], metavar="KEY=VALUE",
                        help="replace a value of the scene file for Mitsuba alone, such as light.0.radius=0.63: a control, which must differ")
    parser.add_argument("--out", type=pathlib.Path, help="write Mitsuba's image as OpenEXR")
    return parser.parse_args()


def triangles(mi, numpy, name, mesh, faces, beside):
    """Mitsuba mesh of some triangles, flat where the mesh has no normals; `beside` holds its BSDF or emitter."""
    properties = mi.Properties()
    for key, value in beside.items():
        properties[key] = mi.load_dict(value)
    smooth = mesh.normals is not None
    properties["face_normals"] = not smooth
    placed = mi.Mesh(name, len(mesh.positions), len(faces), props=properties, has_vertex_normals=smooth,
                     has_vertex_texcoords=mesh.uvs is not None)
    parameters = mi.traverse(placed)
    parameters["vertex_positions"] = numpy.asarray(mesh.positions, numpy.float32).ravel()
    parameters["faces"] = numpy.asarray(faces, numpy.uint32).ravel()
    if mesh.uvs is not None:
        parameters["vertex_texcoords"] = numpy.asarray(mesh.uvs, numpy.float32).ravel()
    parameters.update()
    if smooth:
        # After the positions, which would have normals computed anew.
        parameters["vertex_normals"] = numpy.asarray(mesh.normals, numpy.float32).ravel()
        parameters.update()
    return placed


def placed(mi, numpy, u, v, centre):
    """Transform of Mitsuba's rectangle or disk, whose coordinates run from -1 to 1 along `u` and `v`."""
    normal = numpy.cross(u, v)
    matrix = numpy.eye(4)
    matrix[:3] = numpy.stack([u, v, normal / numpy.linalg.norm(normal), centre], 1)
    return mi.ScalarTransform4f(matrix)


def texture(mi, numpy, light, channel):
    """Radiance of a textured light in one channel, one value a texel. Mitsuba samples texels by their luminance, so that a blue one beside red
    ones would be noisy: each channel is rendered by itself."""
    bitmap = mi.Bitmap(str(light.texture))
    if light.encoding != "auto":
        bitmap.set_srgb_gamma(light.encoding == "srgb")
    bitmap = bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    # The first row of an image is the upper one, and that of a Mitsuba bitmap lies at v = 0.
    texels = numpy.flipud(numpy.array(bitmap)) * numpy.asarray(light.radiance, numpy.float32)
    if light.transposed:
        texels = texels.transpose(1, 0, 2)
    texels = texels * numpy.eye(3, dtype=numpy.float32)[channel]
    bitmap = mi.Bitmap(numpy.ascontiguousarray(texels, numpy.float32))
    return {"type": "bitmap", "bitmap": bitmap, "raw": True, "filter_type": "nearest", "wrap_mode": "clamp"}


def emitter(mi, numpy, scene, light, channel):
    """Shape of a light with its emitter; of a textured one in one channel."""
    radiance = {"type": "rgb", "value": [float(channel) for channel in light.radiance]}
    if light.texture:
        radiance = texture(mi, numpy, light, channel)
    # Lights reflect nothing, but for those that are faces of a mesh.
    beside = {"emitter": {"type": "area", "radiance": radiance}, "bsdf": surfaces.diffuse([0, 0, 0])}
    if light.shape == "polygon":
        faces = [(0, corner, corner + 1) for corner in range(1, len(light.points) - 1)]
        return triangles(mi, numpy, "light", Mesh(light.points, []), faces, beside)
    if light.shape == "faces":
        mesh, part = light.part
        mesh = scene.meshes[mesh]
        material, faces = mesh.parts[part]
        beside["bsdf"] = surfaces.diffuse(material.albedo)
        return triangles(mi, numpy, "light", Mesh(mesh.positions, []), faces, beside)
    if light.shape == "sphere":
        return mi.load_dict({"type": "sphere", "center": [float(x) for x in light.centre], "radius": float(light.radius), **beside})
    kind = "rectangle" if light.shape == "parallelogram" else "disk"
    return mi.load_dict({"type": kind, "to_world": placed(mi, numpy, light.u, light.v, light.centre), **beside})


def read_layer(mi, numpy, path, layer):
    """Three channels of an image of halflight, rows from the top."""
    bitmap = mi.Bitmap(str(path))
    names = [field.name for field in bitmap.struct_()]
    wanted = ["R", "G", "B"] if layer == "radiance" else [f"{layer}.{channel}" for channel in "RGB"]
    missing = [name for name in wanted if name not in names]
    if missing:
        raise Refused(f"{path} has no channel {missing[0]}; it has {', '.join(names)}")
    pixels = numpy.array(bitmap, numpy.float64)
    return numpy.stack([pixels[:, :, names.index(name)] for name in wanted], 2)


def measurement(mi, numpy, world, options, holes):
    """Function that returns the light along a ray, by a sampler and a number of the ray's own. `direct` takes all light samples at once, and takes
    what has holes for solid; `volpath` takes one, and lets light through holes. Paths of indirect light are traced twice, with and without
    their last reflection, by equal random numbers: the direct light of both is the same, and cancels."""
    samples = options.samples

    def integrator(kind, depth):
        return mi.load_dict({"type": kind, "max_depth": depth, "rr_depth": 100, "hide_emitters": True})

    def one(integrator, sampler, ray):
        return numpy.array(integrator.sample(world, sampler, ray)[0])

    if options.layer == "indirect":
        kind = "volpath" if holes else "path"
        deep, shallow = integrator(kind, 3), integrator(kind, 2)

        def indirect(sampler, ray, number):
            total = numpy.zeros(3)
            for sample in range(samples):
                key = number * samples + sample
                for path, sign in ((deep, 1), (shallow, -1)):
                    sampler.seed(key & 0xFFFFFFFF)
                    total += sign * one(path, sampler, ray)
            return total / samples
        return indirect
    if holes:
        path = integrator("volpath", 2)
        return lambda sampler, ray, number: sum(one(path, sampler, ray) for _ in range(samples)) / samples
    direct = mi.load_dict({"type": "direct", "emitter_samples": samples, "bsdf_samples": 0, "hide_emitters": True})
    return lambda sampler, ray, number: one(direct, sampler, ray)


def first_hit(world, ray):
    """Surface that a ray meets first, through holes."""
    while True:
        hit = world.ray_intersect(ray)
        if not hit.is_valid() or hit.bsdf(ray).eval_null_transmission(hit)[0] == 0:
            return hit
        ray = hit.spawn_ray(ray.d)


def render(mi, numpy, world, rays, options, seed, holes):
    """Light from the one emitter of a scene along rays; NaN where the emitter itself is seen."""
    measure = measurement(mi, numpy, world, options, holes)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed)
    origin, directions = rays
    height, width, _ = directions.shape
    image = numpy.zeros((height, width, 3))
    origin = mi.Point3f(*map(float, origin))
    for y in range(height):
        for x in range(width):
            ray = mi.RayDifferential3f(origin, mi.Vector3f(*map(float, directions[y, x])))
            hit = first_hit(world, ray)
            if hit.is_valid() and hit.shape.is_emitter():
                image[y, x] = numpy.nan
            elif hit.is_valid():
                image[y, x] = measure(sampler, ray, (seed * height + y) * width + x)
    return image


def surface_of(mi, numpy, material, options):
    """Mitsuba's surface of a material, without its mask."""
    if options.conductor:
        return surfaces.conductor(*options.conductor)
    if options.layer == "irradiance":
        return surfaces.diffuse([1, 1, 1])
    if material.roughness is None:
        return surfaces.diffuse(material.albedo)
    if material.metallic == 1 and list(material.albedo) == [1, 1, 1]:
        return surfaces.conductor(1, material.roughness)
    return surfaces.gltf(material)


def images(mi, numpy, scene, size, options):
    """Mitsuba's two images, each the sum over the lights. Emitters are geometry to Mitsuba, so that each light has a scene of its own."""
    shapes = {}
    for number, mesh in enumerate(scene.meshes):
        for part, (material, faces) in enumerate(mesh.parts):
            surface = surface_of(mi, numpy, material, options)
            if material.mask:
                surface = surfaces.masked(mi, numpy, surface, material.mask, material.cutoff)
            shapes[number, part] = triangles(mi, numpy, f"mesh{number}-{part}", mesh, faces, {"bsdf": surface})
    holes = any(material.mask for mesh in scene.meshes for material, _ in mesh.parts)
    rays = scene.camera.rays(*size)
    sums = [0.0, 0.0]
    passes = [(light, channel) for light in scene.lights for channel in (range(3) if light.texture else [None])]
    for number, (light, channel) in enumerate(passes):
        others = {f"shape{key[0]}-{key[1]}": shape for key, shape in shapes.items() if key != light.part}
        world = mi.load_dict({"type": "scene", "light": emitter(mi, numpy, scene, light, channel), **others})
        for half in (0, 1):
            sums[half] = sums[half] + render(mi, numpy, world, rays, options, 2 * number + half, holes)
            print(f"pass {number + 1} of {len(passes)}, half {half + 1} of 2: done", file=sys.stderr, flush=True)
    scale = numpy.pi if options.layer == "irradiance" else 1.0
    return [image * scale for image in sums]


def compare(numpy, found, first, second):
    """Text of the comparison over the pixels that Mitsuba does not see its emitter in."""
    mean = (first + second) / 2
    known = numpy.isfinite(mean).all(2)
    found, mean, difference = found[known], mean[known], (first - second)[known]
    energy = (mean ** 2).sum()
    if energy == 0:
        raise Refused("Mitsuba's image is black: no surface in view is lit")
    nmse2, noise = ((found - mean) ** 2).sum() / energy, (difference ** 2).sum() / 4 / energy
    return (f"pixels           {known.sum()} of {known.size}; in the others a light is before the surface\n"
            f"NMSE2            {nmse2:.3e}\n"
            f"of which noise   {noise:.3e} of Mitsuba's image ({noise / nmse2:.0%})\n"
            f"ratio of means   {found.sum() / mean.sum():.5f}")


def main():
    options = arguments()
    try:
        import mitsuba as mi
        import numpy
    except ImportError as fault:
        sys.exit(f"error: {fault.name} is missing: python3 -m pip install numpy mitsuba")
    mi.set_variant("scalar_rgb")
    surfaces.register(mi)
    try:
        changes = [change.split("=", 1) for change in options.change]
        if any(len(change) != 2 for change in changes):
            raise Refused("--change expects KEY=VALUE, such as light.0.radius=0.63")
        scene = scene_file.read(options.scene, changes)
        image = read_layer(mi, numpy, options.image, options.layer)
        height, width, _ = image.shape
        first, second = images(mi, numpy, scene, (width, height), options)
        print(compare(numpy, image, first, second))
    except (Refused, OSError) as fault:
        sys.exit(f"error: {fault}")
    if options.out:
        mi.Bitmap(((first + second) / 2).astype(numpy.float32)).write(str(options.out))


if __name__ == "__main__":
    main()
