"""Mitsuba's surfaces for `compare_with_mitsuba.py`: diffuse, rough conductors, alpha masks, and glTF 2.0 as a BSDF in Python."""
import math


def diffuse(albedo):
    """Lambertian surface, on both sides."""
    reflectance = {"type": "rgb", "value": [float(channel) for channel in albedo]}
    return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": reflectance}}


def conductor(f0, roughness):
    """Rough conductor with the GGX distribution, on both sides. `f0` is one number or three; alpha is the square of the roughness. Without
    a material Mitsuba's Fresnel term is 1, so that `f0` is a constant factor: the comparison holds for reflectances of 1 and, elsewhere, away
    from grazing angles."""
    f0 = [float(f0)] * 3 if isinstance(f0, (int, float)) else [float(channel) for channel in f0]
    inner = {
        "type": "roughconductor", "distribution": "ggx", "material": "none", "alpha": max(float(roughness) ** 2, 1e-4),
        "specular_reflectance": {"type": "rgb", "value": f0},
    }
    return {"type": "twosided", "inner": inner}


def masked(mi, numpy, inner, path, cutoff):
    """Surface with the holes of an image: alpha from the cutoff on is solid; the luminance counts where the image is opaque."""
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGBA, mi.Struct.Type.UInt8, srgb_gamma=True)
    texels = numpy.array(bitmap).astype(numpy.float64) / 255
    alpha = texels[:, :, 3]
    if (alpha == 1).all():
        alpha = texels[:, :, :3] @ numpy.array([0.2126, 0.7152, 0.0722])
    # The first row of an image is the upper one, and that of a Mitsuba bitmap lies at v = 0.
    solid = numpy.ascontiguousarray(numpy.flipud(alpha >= cutoff)[:, :, None], numpy.float32)
    opacity = {"type": "bitmap", "bitmap": mi.Bitmap(solid), "raw": True, "filter_type": "nearest", "wrap_mode": "repeat"}
    return {"type": "mask", "opacity": opacity, "inner": inner}


def gltf(material):
    """Surface of glTF 2.0, on both sides; `register` makes it known to Mitsuba."""
    diffuse = [(1 - material.metallic) * channel for channel in material.albedo]
    values = {"alpha": float(material.roughness) ** 2}
    for name, colour in (("diffuse", diffuse), ("f0", material.f0())):
        values |= {f"{name}{channel}": float(value) for channel, value in enumerate(colour)}
    return {"type": "gltf", **values}


def register(mi):
    """Makes the surface `gltf` known: diffuse plus GGX with Smith's separable term and Schlick's Fresnel term (glTF 2.0, Appendix B). Mitsuba's
    own `principled` has another diffuse lobe and `roughplastic` another Fresnel term."""

    class Gltf(mi.BSDF):
        def __init__(self, properties):
            mi.BSDF.__init__(self, properties)
            flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components, self.m_flags = [flags], flags
            self.alpha_squared = properties["alpha"] ** 2
            self.diffuse, self.f0 = ([properties[f"{name}{channel}"] for channel in range(3)] for name in ("diffuse", "f0"))

        def eval(self, context, hit, to, active=True):
            view = hit.wi
            side = 1.0 if view.z > 0 else -1.0
            seen, lit = side * view.z, side * to.z
            if seen <= 0 or lit <= 0:
                return mi.Color3f(0)
            half = (view.x + to.x, view.y + to.y, side * (view.z + to.z))
            length = math.sqrt(half[0] ** 2 + half[1] ** 2 + half[2] ** 2)
            squared = self.alpha_squared
            spread = (half[2] / length) ** 2 * (squared - 1) + 1
            distribution = squared / (math.pi * spread * spread)
            # Smith's terms of both directions, over four times both cosines.
            smith = (seen + math.sqrt(squared + (1 - squared) * seen * seen)) * (lit + math.sqrt(squared + (1 - squared) * lit * lit))
            weight = (1 - (view.x * half[0] + view.y * half[1] + seen * half[2]) / length) ** 5
            lobe = distribution / smith
            return mi.Color3f([lit * (kd / math.pi + lobe * (f0 + (1 - f0) * weight)) for kd, f0 in zip(self.diffuse, self.f0)])

        def pdf(self, context, hit, to, active=True):
            return 0.0

        def eval_pdf(self, context, hit, to, active=True):
            return self.eval(context, hit, to, active), 0.0

        def sample(self, context, hit, first, second, active=True):
            return mi.BSDFSample3f(), mi.Color3f(0)

    mi.register_bsdf("gltf", Gltf)
