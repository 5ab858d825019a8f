"""Scenes by chance, for training: a number makes a room or a place outdoors with its lights, surfaces, things, camera, lens and motion.

They share the kit with the scenes of the test set, and neither things, surfaces, places nor views.
"""
import colorsys
import math

from kit import (area, ball, begin, blades, box, bulb, camera, floor, lathe, move, scatter, shape, shutter, spark, stream, sun,
                 surroundings, wall, wires)
from surfaces import glass, glowing, metal, surface, thin_cloth

PROBES = ("night", "sunrise", "sunset")  # those that no scene of the test set uses
TEXTURES = ("brick", "checker", "noise", "voronoi", "wood", "rings", "marble")


def colour(rng, low=0.03, high=0.9):
    """Any hue; bright colours are mostly pale, as paint and cloth are."""
    value = low + (high - low) * rng.random()
    return colorsys.hsv_to_rgb(rng.random(), rng.random() ** 1.5, value)


def warmth(rng):
    """The colour of a lamp, from candle to sky."""
    t = rng.random()
    return (1.0, 0.55 + 0.4 * t, 0.25 + 0.75 * t)


def matter(rng, large=False):
    """A surface; on a large one mostly diffuse and textured."""
    kind = rng.random()
    if not large and kind < 0.13:
        return glass(colorsys.hsv_to_rgb(rng.random(), 0.5 * rng.random(), 1), rng.choice((0, 0, 0.1, 0.3)), rng.uniform(1.2, 1.7))
    if kind < (0.04 if large else 0.28):
        return metal(colour(rng, 0.4), 0.6 * rng.random() ** 2)
    if not large and kind < 0.34:
        return thin_cloth(colour(rng, 0.2), rng.random())
    inputs = {"Roughness": rng.uniform(0.15, 1), "Coat_Weight": rng.choice((0, 0, 0.5))}
    if rng.random() < (0.25 if large else 0.45):
        return surface(colour(rng), **inputs)
    texture = rng.choice(TEXTURES)
    return surface(texture=texture, scale=math.exp(rng.uniform(-0.7, 1.8)), colours=[colour(rng) for _ in range(3 if texture == "brick" else 2)],
                   stretch=[math.exp(rng.uniform(-0.8, 0.8)) for _ in range(3)], bump=rng.choice((0, 0, rng.uniform(-0.8, 0.8))),
                   seed=rng.randrange(1000), **inputs)


def profile(rng):
    """Of a vessel, a bulb or a baluster."""
    steps = rng.randrange(4, 8)
    waist = rng.uniform(0.25, 0.7)
    points = [(0, 0)] + [(max(waist + rng.uniform(-0.25, 0.35), 0.08), i / steps * 1.6) for i in range(steps)]
    return (*points, (0, 1.6)) if rng.random() < 0.6 else (*points, (points[-1][0] - 0.05, 1.6), (points[-1][0] - 0.07, 0.3), (0, 0.25))


def thing(rng, where):
    """One object that stands at `where`, its largest side about 1."""
    x, y, z = where
    size = math.exp(rng.uniform(-1.2, 0.5))
    turn = rng.uniform(0, 2 * math.pi)
    kind = rng.randrange(9)
    material = matter(rng)
    if kind == 0:
        return ball(material, (x, y, z + 0.5 * size), 0.5 * size)
    if kind == 1:
        return box(material, where, [size * rng.uniform(0.4, 1.2) for _ in range(3)], (0, 0, turn), rng.choice((0, 0.03)))
    if kind == 2:
        return shape("cylinder", material, (x, y, z + 0.5 * size), radius=size * rng.uniform(0.1, 0.5), depth=size)
    if kind == 3:
        return shape("torus", material, (x, y, z + 0.3 * size), turn=(rng.uniform(0, 1.6), 0, turn), major_radius=0.4 * size,
                     minor_radius=size * rng.uniform(0.03, 0.18))
    if kind == 4:
        return shape("monkey", material, (x, y, z + 0.5 * size), turn=(rng.uniform(-0.7, 0.3), 0, turn), size=size)
    if kind == 5:
        return shape("cone", material, (x, y, z + 0.5 * size), radius1=0.5 * size, depth=size)
    if kind == 6:
        lines = []
        for _ in range(rng.randrange(3, 12)):
            a, bend, top = rng.uniform(0, 2 * math.pi), rng.uniform(0.1, 0.6) * size, rng.uniform(0.8, 2) * size
            lines.append([(x + bend * t * t * math.cos(a + t), y + bend * t * t * math.sin(a + t), z + top * t) for t in (0, 0.25, 0.5, 0.75, 1)])
        return wires(lines, size * rng.uniform(0.008, 0.04), material)
    made = lathe(profile(rng), material, where, rounded=rng.random() < 0.7)
    made.scale = (size, size, size)
    return made


def lights(rng, indoors):
    """One or two lamps that reach the scene, and now and then sparks and bulbs that are seen."""
    for _ in range(rng.randrange(1, 3) if indoors or rng.random() < 0.6 else 0):
        angle, height = rng.uniform(0, 2 * math.pi), rng.uniform(2.5, 4.6)
        size = math.exp(rng.uniform(-1.8, 1.0))
        area((3.4 * math.cos(angle), 3.4 * math.sin(angle), height), (0, 0, 0.5), size, 40 * height * height * rng.uniform(0.5, 1.5), warmth(rng))
    if not indoors and rng.random() < 0.6:
        sun((rng.uniform(-4, 4), rng.uniform(-4, 4), rng.uniform(1, 5)), rng.uniform(0.8, 4), warmth(rng), 0.3 * rng.random() ** 3)
    if rng.random() < 0.35:
        for place in scatter(rng.randrange(1, 3), rng, (-3, -3), (3, 3), rng.uniform(0.6, 3)):
            bulb(place, rng.uniform(20, 120), rng.uniform(0.02, 0.15), warmth(rng))
    if rng.random() < 0.35:
        for place in scatter(rng.randrange(3, 20), rng, (-3.8, -3.8), (3.8, 3.8)):
            spark(glowing(colour(rng, 0.6), rng.uniform(4, 30)), (place[0], place[1], rng.uniform(0.1, 3.5)), rng.uniform(0.03, 0.1))


def build(number):
    """Everything of scene `number`, its camera included."""
    rng = stream(f"training {number}")
    begin(math.exp(rng.uniform(-1.0, 0.6)))
    indoors = rng.random() < 0.45
    angle, away = rng.uniform(0, 2 * math.pi), rng.uniform(2.8, 4.2 if indoors else 7.0)
    place = (away * math.cos(angle), away * math.sin(angle), rng.uniform(0.6, 3.2))
    surroundings(math.exp(rng.uniform(-1.5, 0.4)), rng.choice((None, *PROBES)), rng.uniform(0, 6), colour(rng, 0.3))
    floor(matter(rng, True), 9 if indoors else 60)
    if indoors:  # a room with two to four walls; the camera is inside
        paint = matter(rng, True)
        for side in range(rng.randrange(2, 5)):
            turn = side * math.pi / 2
            wall(paint if rng.random() < 0.6 else matter(rng, True), (4.5 * math.sin(turn), 4.5 * math.cos(turn), 0), 9, 5, -turn)
        if rng.random() < 0.7:
            floor(matter(rng, True), 9, 5.0)
    elif rng.random() < 0.5:
        behind, far = angle + math.pi + rng.uniform(-0.5, 0.5), rng.uniform(3, 6)
        wall(matter(rng, True), (far * math.cos(behind), far * math.sin(behind), 0), rng.uniform(4, 30), rng.uniform(2, 9),
             behind - math.pi / 2 + rng.uniform(-0.5, 0.5))
    if rng.random() < 0.25:
        blades(scatter(rng.randrange(50, 700), rng, (-3, -3), (3, 3)), rng.uniform(0.3, 1), rng.uniform(0.02, 0.08), matter(rng), rng)
    stands = []
    if rng.random() < 0.5:  # a table
        top = rng.uniform(0.4, 1.0)
        box(matter(rng, True), (0, 0, 0), (3.4, 2.2, top), bevel=0.03)
        stands = [(rng.uniform(-1.5, 1.5), rng.uniform(-0.9, 0.9), top) for _ in range(rng.randrange(3, 10))]
    stands += scatter(rng.randrange(8, 30), rng, (-3.6, -3.6), (3.6, 3.6))
    things = [thing(rng, stand) for stand in stands if math.dist(stand, place) > 2]  # nothing fills the picture
    lights(rng, indoors)

    target = (rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.2, 1.2))
    lens = rng.uniform(22, 60)
    wide = rng.random() < 0.5
    seen = camera(place, target, lens, target, lens / rng.uniform(30, 160) if wide else None)
    if rng.random() < 0.4:
        shutter(rng.uniform(0.3, 1))
        for made in rng.sample(things, min(len(things), rng.randrange(1, 9))):
            move(made, [rng.uniform(-0.8, 0.8) for _ in range(3)], [rng.choice((0, rng.uniform(-2, 2))) for _ in range(3)])
        if rng.random() < 0.4:
            move(seen, [rng.uniform(-0.25, 0.25) for _ in range(3)], [rng.uniform(-0.04, 0.04) for _ in range(3)])
