#!/usr/bin/env python3
"""Materials, lights and tone maps beside the Khronos glTF Sample Renderer.

    python3 conformance/fidelity.py --rtrt target/release/rtrt --viewer FOLDER [--out FOLDER] [CASE ...]

makes a glTF file for each case (a row of balls, one number of a material changing from ball to ball), draws it with
that renderer and with `rtrt`, and prints how far apart the pictures are: the mean and the 95th percentile of the
difference of a channel, of 255, and the median of the light, in stops. A case that is farther apart than its bound is an
error.

FOLDER holds what draws the references: `reference.mjs`, `page.html`, `luts/` and the npm packages that they name, as
the README of ../shared/fidelity says. Without that folder, or without Pillow and numpy, nothing is compared, and a line
says so. References that are in the output folder are not drawn again.

What the reference approximates, and what is done about it:

- It encodes colors by a power of 2.2 where sRGB has its curve: dark colors are up to 8 of 255 brighter. That is undone
  before pictures are compared.
- Its environments are blurred with few samples: under a small sun, diffuse light is off by up to 0.17 stops. The
  environment here is soft.
- It has neither shadows nor occlusion. They are off.
- What a colored highlight takes of the diffuse color it takes channel by channel; KHR_materials_specular and
  pbrSpecularGlossiness take the largest channel of all. Highlights here are gray.
- Its tables of sheens hold up to twice the integral of the formula of KHR_materials_sheen. Bounds are wide there.
- A lamp has no highlight on a surface of roughness 0; here it is one of 0.044.
- It averages and blends encoded colors, which edges show."""
import argparse, base64, json, math, os, shutil, struct, subprocess, sys

HERE = os.path.dirname(os.path.abspath(__file__))
SIDE = 96
GAP = 2.3


def ball(columns=64, rows=32):
    """Positions, normals, tangents, texture coordinates and indices of a ball of radius 1."""
    positions, tangents, coordinates, indices = [], [], [], []
    for r in range(rows + 1):
        for c in range(columns + 1):
            turn, down = 2 * math.pi * c / columns, math.pi * r / rows
            positions.append((math.sin(down) * math.sin(turn), math.cos(down), math.sin(down) * math.cos(turn)))
            tangents.append((math.cos(turn), 0.0, -math.sin(turn), 1.0))
            coordinates.append((c / columns, r / rows))
    for r in range(rows):
        for c in range(columns):
            a, b = r * (columns + 1) + c, (r + 1) * (columns + 1) + c
            # The triangles at the poles have no area.
            indices += ([a, b, a + 1] if r else []) + ([a + 1, b, b + 1] if r < rows - 1 else [])
    return positions, positions, tangents, coordinates, indices


def gltf(materials, lights=(), backdrop=None):
    """A file with a row of balls, one a material, lights as (light, translation, rotation), and a striped wall."""
    data, views, accessors = bytearray(), [], []

    def accessor(values, kind, component, code):
        start = len(data)
        for value in values:
            data.extend(struct.pack("<" + code * (1 if kind == "SCALAR" else len(value)), *((value,) if kind == "SCALAR" else value)))
        views.append({"buffer": 0, "byteOffset": start, "byteLength": len(data) - start})
        entry = {"bufferView": len(views) - 1, "componentType": component, "count": len(values), "type": kind}
        if kind == "VEC3":
            entry |= {"min": [min(v[i] for v in values) for i in range(3)], "max": [max(v[i] for v in values) for i in range(3)]}
        accessors.append(entry)
        return len(accessors) - 1

    p, n, t, uv, i = ball()
    attributes = {
        "POSITION": accessor(p, "VEC3", 5126, "f"), "NORMAL": accessor(n, "VEC3", 5126, "f"),
        "TANGENT": accessor(t, "VEC4", 5126, "f"), "TEXCOORD_0": accessor(uv, "VEC2", 5126, "f"),
    }
    indices = accessor(i, "SCALAR", 5123, "H")
    materials = list(materials)
    meshes = [{"primitives": [{"attributes": attributes, "indices": indices, "material": m}]} for m in range(len(materials))]
    nodes = [{"mesh": m, "translation": [GAP * (m - (len(materials) - 1) / 2), 0, 0]} for m in range(len(materials))]
    if backdrop:
        # Stripes behind the balls, each a quad.
        half = GAP * len(materials) / 2 + 1
        for stripe in range(int(half * 4)):
            x, y, z = -half + stripe / 2, 2.0, -2.5
            corners = [(x, -y, z), (x + 0.5, -y, z), (x + 0.5, y, z), (x, y, z)]
            quad = {"POSITION": accessor(corners, "VEC3", 5126, "f"), "NORMAL": accessor([(0.0, 0.0, 1.0)] * 4, "VEC3", 5126, "f")}
            meshes.append({"primitives": [{"attributes": quad, "indices": accessor([0, 1, 2, 0, 2, 3], "SCALAR", 5123, "H"), "material": len(materials) + stripe % 2}]})
            nodes.append({"mesh": len(meshes) - 1})
        materials += [surface(color, 0, 1) for color in backdrop]
    used = sorted({e for m in materials for e in m.get("extensions", {})} | ({"KHR_lights_punctual"} if lights else set()))
    file = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes) + len(lights)))}], "extensionsUsed": used,
        "nodes": nodes, "meshes": meshes, "materials": materials, "accessors": accessors, "bufferViews": views,
    }
    if lights:
        file["extensions"] = {"KHR_lights_punctual": {"lights": [light for light, _, _ in lights]}}
        for number, (_, translation, rotation) in enumerate(lights):
            nodes.append({"translation": translation, "rotation": rotation, "extensions": {"KHR_lights_punctual": {"light": number}}})
    if not used:
        del file["extensionsUsed"]
    file["buffers"] = [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]
    return file


def surface(color, metallic, roughness, **extensions):
    """A material; extensions are given by the ends of their names."""
    return {
        "pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": metallic, "roughnessFactor": roughness},
        "extensions": {"KHR_materials_" + name: values for name, values in extensions.items()},
    }


def sky(path, strength, width=512, height=256):
    """Writes a soft panorama: a gradient, and three broad lamps, all of it times `strength`."""
    lamps = [((0.5, 0.6, 0.62), (3.0, 2.8, 2.5), 6.0), ((-0.8, 0.3, 0.5), (0.4, 0.9, 1.6), 4.0), ((0.1, -0.2, -1.0), (1.5, 0.6, 0.3), 5.0)]

    def light(x, y, z):
        color = [0.15 + 0.35 * (y + 1) / 2, 0.18 + 0.32 * (y + 1) / 2, 0.2 + 0.4 * (y + 1) / 2]
        for at, tint, narrow in lamps:
            length = math.sqrt(sum(c * c for c in at))
            share = math.exp(narrow * ((x * at[0] + y * at[1] + z * at[2]) / length - 1))
            color = [c + t * share for c, t in zip(color, tint)]
        return [c * strength for c in color]

    with open(path, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width))
        for row in range(height):
            down = math.pi * (row + 0.5) / height
            planes = [bytearray() for _ in range(4)]
            for column in range(width):
                turn = 2 * math.pi * ((column + 0.5) / width - 0.5)
                color = light(math.sin(down) * math.cos(turn), math.cos(down), math.sin(down) * math.sin(turn))
                exponent = math.frexp(max(color))[1]
                for plane, value in zip(planes, [int(c * 2.0 ** (8 - exponent)) for c in color] + [exponent + 128]):
                    plane.append(value)
            file.write(bytes([2, 2, width >> 8, width & 255]))
            for plane in planes:
                for start in range(0, width, 128):
                    part = plane[start : start + 128]
                    file.write(bytes([len(part)]) + part)


RED, WHITE, GOLD = (0.7, 0.05, 0.03), (0.8, 0.8, 0.8), (0.95, 0.7, 0.3)
STEPS = [0, 0.25, 0.5, 0.75, 1]
METALS = [surface(GOLD, 1, r) for r in STEPS] + [surface(RED, 0, r) for r in STEPS]
SUN = ({"type": "directional", "intensity": 2.0, "color": [1, 0.95, 0.9]}, [0, 0, 0], [-0.35, 0.25, 0, 0.9])
LAMPS = [
    SUN,
    ({"type": "point", "intensity": 18.0, "color": [0.4, 0.6, 1]}, [-4, 3, 3], [0, 0, 0, 1]),
    ({"type": "spot", "intensity": 60.0, "range": 12, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}}, [5, 0.5, 6], [0, 0.15, 0, 0.99]),
]


def glossy(roughness):
    glossiness = {"diffuseFactor": [*RED, 1], "specularFactor": [0.2, 0.2, 0.2], "glossinessFactor": 1 - roughness}
    return {"extensions": {"KHR_materials_pbrSpecularGlossiness": glossiness}}


# Name: materials; what differs from a case under the soft sky; the largest mean, 95th percentile and light in stops.
CASES = {
    "metallic-roughness": (METALS, {}, (1.6, 6, 0.03)),
    "lights": (METALS, {"lamps": LAMPS}, (1.0, 3, 0.03)),
    "specular": ([surface(RED, 0, 0.3, specular={"specularFactor": s}) for s in STEPS]
                 + [surface(RED, 0, 0.3, specular={"specularColorFactor": c}) for c in ([0.3, 0.3, 0.3], [6, 6, 6])], {}, (1.0, 3, 0.03)),
    "ior": ([surface(RED, 0, 0.2, ior={"ior": i}) for i in (1, 1.33, 1.5, 1.8, 2.4)], {}, (1.0, 3, 0.03)),
    "clearcoat": ([surface(RED, m, 0.6, clearcoat={"clearcoatFactor": f, "clearcoatRoughnessFactor": r})
                   for m in (0, 1) for f, r in ((0.5, 0), (1, 0), (1, 0.3), (1, 0.8))], {}, (1.6, 5, 0.03)),
    "clearcoat-lights": ([surface(RED, 0, 0.6, clearcoat={"clearcoatFactor": f, "clearcoatRoughnessFactor": r})
                          for f, r in ((0.5, 0.1), (1, 0.1), (1, 0.3), (1, 0.8))], {"lamps": LAMPS}, (1.5, 4, 0.03)),
    "sheen": ([surface((0.1, 0.05, 0.3), 0, 0.8, sheen={"sheenColorFactor": c, "sheenRoughnessFactor": r})
               for c in ([1, 1, 1], [0.3, 0.1, 0.05]) for r in (0.2, 0.4, 0.7, 1)], {}, (12.0, 40, 0.25)),
    "sheen-lights": ([surface((0.1, 0.05, 0.3), 0, 0.8, sheen={"sheenColorFactor": c, "sheenRoughnessFactor": r})
                      for c in ([1, 1, 1], [0.3, 0.1, 0.05]) for r in (0.2, 0.4, 0.7, 1)], {"lamps": LAMPS}, (2.5, 8, 0.06)),
    "pbrSpecularGlossiness": ([glossy(r) for r in STEPS], {}, (1.3, 4, 0.03)),
    "anisotropy": ([surface(GOLD, 1, 0.3, anisotropy={"anisotropyStrength": s, "anisotropyRotation": a})
                    for a in (0, math.pi / 2) for s in (0, 0.4, 0.7, 1)], {}, (1.5, 4, 0.03)),
    "anisotropy-lights": ([surface(GOLD, 1, 0.3, anisotropy={"anisotropyStrength": s, "anisotropyRotation": a})
                           for a in (0, math.pi / 2) for s in (0, 0.4, 0.7, 1)], {"lamps": LAMPS}, (1.5, 5, 0.03)),
    "iridescence": ([surface(c, m, 0.15, iridescence={"iridescenceFactor": 1, "iridescenceIor": 1.3, "iridescenceThicknessMaximum": t})
                     for c, m in ((GOLD, 1), ((0.02, 0.02, 0.02), 0)) for t in (150, 300, 500, 800)], {}, (1.7, 6, 0.03)),
    "transmission": ([surface((0.8, 0.95, 0.9), 0, 0, transmission={"transmissionFactor": f}) for f in (0.25, 0.5, 0.75, 1)],
                     {"wall": [(0.8, 0.8, 0.8), (0.05, 0.05, 0.2)]}, (3.2, 12, 0.03)),
    "tone-neutral": (METALS, {"toneMap": "KHR_PBR_NEUTRAL", "rtrt": "neutral"}, (1.7, 6.5, 0.03)),
    "tone-aces": (METALS, {"toneMap": "ACES_HILL", "rtrt": "aces"}, (1.7, 6, 0.03)),
}


def write(folder, names):
    """Writes the files of the cases, and the list that the reference renderer reads."""
    sky(os.path.join(folder, "sky.hdr"), 1)
    # The reference renderer draws nothing without an environment.
    sky(os.path.join(folder, "black.hdr"), 0)
    cases = []
    for name in names:
        materials, differs, _ = CASES[name]
        with open(os.path.join(folder, name + ".gltf"), "w") as file:
            json.dump(gltf(materials, differs.get("lamps", ()), differs.get("wall")), file)
        distance = 20.0
        case = {
            "name": name, "scene": name + ".gltf", "size": [SIDE * len(materials), SIDE], "eye": [0, 1.5, distance], "lookAt": [0, 0, 0],
            "fovY": 2 * math.degrees(math.atan(GAP / 2 / math.hypot(distance, 1.5))), "lights": "lamps" in differs,
            "rtrt": ["--tone-map", differs.get("rtrt", "none"), "--environment-sun", "keep", "--ambient-occlusion", "off", "--no-shadows", "--backend", "cpu"],
        }
        case["environment"] = "black.hdr" if "lamps" in differs else "sky.hdr"
        if "toneMap" in differs:
            case["toneMap"] = differs["toneMap"]
        cases.append(case)
    with open(os.path.join(folder, "cases.json"), "w") as file:
        json.dump(cases, file, indent=1)
    return cases


def draw_references(viewer, folder, cases):
    """Draws the references that are missing."""
    references = os.path.join(folder, "reference")
    missing = [c for c in cases if not os.path.exists(os.path.join(references, c["name"] + ".png"))]
    if missing:
        listed = os.path.join(folder, "missing.json")
        with open(listed, "w") as file:
            json.dump(missing, file)
        subprocess.run(["node", "reference.mjs", os.path.abspath(listed), os.path.abspath(references)], cwd=viewer, check=True)
    return references


def apart(reference, ours):
    """Mean and 95th percentile of the difference, of 255, and the median of the light in stops."""
    import numpy as np
    from PIL import Image

    a, b = (np.asarray(Image.open(file).convert("RGBA"), float) / 255 for file in (reference, ours))
    both = (a[..., 3] == 1) & (b[..., 3] == 1)
    encode = lambda c: np.where(c <= 0.0031308, c * 12.92, 1.055 * np.maximum(c, 1e-9) ** (1 / 2.4) - 0.055)
    decode = lambda c: np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    a, b = encode(a[both][:, :3] ** 2.2), b[both][:, :3]
    difference = np.abs(a - b) * 255
    luminance = np.array([0.2126, 0.7152, 0.0722])
    stops = np.log2((decode(b) @ luminance + 1e-3) / (decode(a) @ luminance + 1e-3))
    return difference.mean(), np.percentile(difference, 95), np.median(stops)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rtrt", default="rtrt")
    parser.add_argument("--viewer")
    parser.add_argument("--out", default="fidelity")
    parser.add_argument("cases", nargs="*", choices=[[], *CASES])
    options = parser.parse_args()
    compare = os.path.join(HERE, "..", "..", "shared", "fidelity", "compare.py")
    if not os.path.exists(compare):
        return print("skipped: there is no ../shared/fidelity/compare.py")
    try:
        import numpy, PIL  # noqa: F401
    except ImportError as error:
        return print(f"skipped: {error}")
    if not options.viewer or not os.path.exists(os.path.join(options.viewer, "node_modules")) or not shutil.which("node"):
        return print("skipped: --viewer names no folder with the reference renderer, or there is no node")
    os.makedirs(options.out, exist_ok=True)
    names = options.cases or list(CASES)
    cases = write(options.out, names)
    references = draw_references(options.viewer, options.out, cases)
    ours = os.path.join(options.out, "ours")
    subprocess.run([sys.executable, compare, os.path.join(options.out, "cases.json"), references, ours, options.rtrt], check=True)
    print("with the curve of sRGB in both:")
    wrong = 0
    for name in names:
        found = apart(*(os.path.join(folder, name + ".png") for folder in (references, ours)))
        bounds = CASES[name][2]
        is_far = found[0] > bounds[0] or found[1] > bounds[1] or abs(found[2]) > bounds[2]
        wrong += is_far
        print("%-24s mean %5.2f (at most %g)  95 %% within %5.1f (%g)  light %+.3f (%g)%s" % (
            name, found[0], bounds[0], found[1], bounds[1], found[2], bounds[2], "  TOO FAR" if is_far else ""))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
