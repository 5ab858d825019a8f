"""Scenes in focus that stand still: textures, glass, thin things, a room, metals. Each builds its camera for `view` 0 or 1."""
import math

from kit import (area, ball, begin, blades, box, bulb, camera, floor, lathe, scatter, shape, spark, stream, sun, surroundings, wall,
                 wires)
from surfaces import glass, glowing, metal, surface, thin_cloth


def courtyard(view):
    """Brick, planks, tiles, marble and plaster under a sky and an area light."""
    begin(0.33)
    surroundings(0.9, "city", 2.4)
    tiles = dict(texture="checker", scale=1.0, colours=((0.6, 0.55, 0.48), (0.28, 0.25, 0.24)))
    floor(surface(Roughness=0.45, **tiles))
    brick = dict(texture="brick", colours=((0.42, 0.13, 0.08), (0.55, 0.24, 0.14), (0.55, 0.52, 0.47)), bump=-0.8, Roughness=0.8)
    wall(surface(scale=1.6, **brick), (0, 3.5, 0), 14, 6)
    wall(surface(texture="noise", scale=1.5, colours=((0.62, 0.5, 0.3), (0.78, 0.68, 0.48)), bump=0.5, Roughness=0.9), (5, 0, 0), 14, 6,
         -math.pi / 2)
    for i, (x, y, z, turn) in enumerate(((-2.6, 1.6, 0, 0.3), (-1.1, 2.1, 0, -0.2), (-2.0, 1.9, 1.3, 0.7))):
        planks = surface(texture="wood", scale=2.4, colours=((0.3, 0.16, 0.07), (0.6, 0.4, 0.22)), stretch=(0.3, 1.8, 1.8), seed=i, Roughness=0.55)
        box(planks, (x, y, z), (1.3, 1.3, 1.3), (0, 0, turn), 0.03)
        frame = surface(texture="wood", scale=2, colours=((0.24, 0.12, 0.05), (0.4, 0.25, 0.13)), stretch=(1.8, 0.3, 1.8), seed=i + 3, Roughness=0.6)
        for height in (0, 1.16):
            box(frame, (x, y, z + height), (1.36, 1.36, 0.14), (0, 0, turn), 0.02)
    ball(surface(texture="marble", scale=0.7, colours=((0.75, 0.73, 0.7), (0.2, 0.22, 0.25)), Roughness=0.12), (0.6, 0.2, 0.85), 0.85)
    lathe(((0, 0), (0.5, 0), (0.75, 0.5), (0.8, 0.95), (0.55, 1.35), (0.62, 1.5), (0.52, 1.5), (0.42, 1.3), (0, 1.2)),
          surface(texture="voronoi", scale=4, colours=((0.1, 0.25, 0.4), (0.75, 0.7, 0.55)), Roughness=0.25), (2.5, 1.4, 0))
    shape("cylinder", surface(texture="noise", scale=3, colours=((0.3, 0.1, 0.04), (0.35, 0.36, 0.38)), Roughness=0.5), (3.7, 2.6, 0.8), radius=0.55,
          depth=1.6)
    box(surface(texture="brick", scale=4, colours=((0.2, 0.35, 0.3), (0.3, 0.45, 0.35), (0.7, 0.7, 0.65)), Roughness=0.2), (-0.6, -0.9, 0),
        (0.9, 0.9, 0.55), (0, 0, 0.5), 0.02)
    area((-4, -4, 6), (0, 1, 0.5), 2.5, 1300, (1, 0.9, 0.75))
    if view == 0:
        camera((-0.6, -6.0, 2.4), (0.3, 1, 0.95), 38)
    else:
        camera((-3.9, -3.6, 1.9), (0.4, 1.2, 0.9), 36)


GOBLET = ((0, 0), (0.75, 0.02), (0.78, 0.06), (0.2, 0.14), (0.09, 0.3), (0.08, 1.2), (0.2, 1.4), (0.7, 1.85), (0.86, 2.4), (0.7, 3.1), (0.66, 3.1),
          (0.81, 2.4), (0.65, 1.9), (0.2, 1.5), (0, 1.45))
WINE = ((0, 1.44), (0.2, 1.48), (0.67, 1.88), (0.83, 2.38), (0, 2.39))
TUMBLER = ((0, 0), (0.6, 0), (0.64, 0.05), (0.74, 1.7), (0.69, 1.7), (0.61, 0.2), (0.56, 0.14), (0, 0.14))
LEMON = ((0, -0.62), (0.1, -0.54), (0.27, -0.38), (0.38, 0), (0.27, 0.38), (0.1, 0.52), (0.06, 0.6), (0, 0.61))
JUICE = ((0, 0.13), (0.57, 0.13), (0.625, 0.2), (0.68, 1.2), (0, 1.2))


def liquids(view):
    """Goblets with wine, tumblers with juice, coloured bottles and a glass ball on a pale table."""
    begin(0.42)
    surroundings(0.9, "courtyard", 1.2)
    floor(surface(texture="wood", scale=0.6, colours=((0.5, 0.36, 0.23), (0.66, 0.52, 0.36)), stretch=(0.25, 1.6, 1), Roughness=0.35))
    wall(surface(texture="noise", scale=0.7, colours=((0.5, 0.53, 0.52), (0.66, 0.66, 0.62)), Roughness=0.8), (0, 5.5, 0), 60, 16)
    clear = glass((1, 1, 1))
    for x, y, tint in ((-1.9, 0.2, (0.75, 0.05, 0.08)), (0.1, 1.2, (0.9, 0.75, 0.3))):
        lathe(GOBLET, clear, (x, y, 0))
        lathe(WINE, glass((1, 1, 1), ior=1.33, absorbs=tint, density=2.2), (x, y, 0), rounded=False)
    for x, y, tint in ((1.7, -0.4, (0.95, 0.45, 0.05)), (3.0, 1.4, (0.2, 0.6, 0.9))):
        lathe(TUMBLER, clear, (x, y, 0), rounded=False)
        lathe(JUICE, glass((1, 1, 1), ior=1.33, absorbs=tint, density=1.6), (x, y, 0), rounded=False)
    flask = ((0, 0.04), (0.6, 0.02), (0.75, 0.15), (0.78, 1.0), (0.7, 1.5), (0.3, 2.1), (0.24, 2.9), (0.32, 3.0), (0.32, 3.12), (0.18, 3.12), (0.16, 2.2),
             (0.6, 1.45), (0.68, 1.0), (0.65, 0.25), (0.5, 0.16), (0, 0.16))
    for x, y, tint in ((-3.2, 2.2, (0.25, 0.65, 0.35)), (-1.4, 2.9, (0.2, 0.35, 0.85)), (1.8, 3.0, (0.85, 0.45, 0.12))):
        lathe(flask, glass(tuple(0.5 + 0.5 * c for c in tint), absorbs=tint, density=1.2), (x, y, 0))
    ball(glass((0.97, 1, 0.99)), (-0.4, -1.3, 0.55), 0.55)
    ball(glass((0.9, 0.95, 1), 0.25), (2.9, -1.4, 0.42), 0.42)
    for i in range(5):
        box(glass((0.97, 0.99, 1), 0.05, 1.31), (0.5 + 0.45 * (i % 3), -2.2 + 0.5 * (i // 3), 0), (0.36, 0.36, 0.36), (0, 0, 0.6 * i), 0.05)
    for i, (x, y) in enumerate(((-2.6, -1.2), (-2.2, -1.9), (-3.3, -0.6))):
        lathe(LEMON, surface((0.75, 0.58, 0.06), Roughness=0.4), (x, y, 0.38), turn=(1.5, 0, 0.9 * i))
    area((-5, -1, 7), (0, 0.5, 0.5), 3, 900, (1, 0.95, 0.88), height=4)
    area((6, 3, 5), (0, 0.5, 1), 2, 300, (0.85, 0.92, 1))
    if view == 0:
        camera((0.2, -8.8, 3.0), (0, 0.6, 1.35), 42)
    else:
        camera((-5.6, -5.4, 2.2), (0.1, 0.7, 1.3), 44)


def garden(view):
    """Grass, stalks with leaves and a wire fence in the sun."""
    begin(0.8)
    rng = stream("garden")
    surroundings(0.8, "forest", 1.9)
    floor(surface(texture="noise", scale=2, colours=((0.1, 0.06, 0.03), (0.22, 0.15, 0.08)), bump=0.5, Roughness=0.95))
    for i, tint in enumerate(((0.16, 0.32, 0.06), (0.24, 0.38, 0.1), (0.4, 0.38, 0.16))):
        blades(scatter((2600, 2200, 700)[i], rng, (-5, -3.5), (5, 5)), (0.75, 0.55, 0.95)[i], 0.055, thin_cloth(tint, 0.35), rng, 0.7)
    steel, wood = metal((0.62, 0.64, 0.66), 0.35), surface(texture="wood", scale=2, colours=((0.3, 0.2, 0.12), (0.5, 0.36, 0.22)), stretch=(2, 2, 0.3))
    mesh, cell = [], 0.3
    for k in range(-17, 18):  # two families of zigzags make the diamonds
        for way in (1, -1):
            mesh.append([(cell * (k + 0.5 * way * (j % 2)), 1.6 + 0.02 * way * (1 - 2 * (j % 2)), 0.15 + 0.5 * cell * j) for j in range(15)])
    wires(mesh, 0.011, steel, 4)
    wires([[(-5, 1.6, z), (5, 1.6, z)] for z in (0.15, 2.3)], 0.02, steel)
    for x in (-3.6, -1.2, 1.2, 3.6):
        shape("cylinder", wood, (x, 1.68, 1.25), radius=0.08, depth=2.5)
    leaf, stem = thin_cloth((0.12, 0.33, 0.08), 0.4), surface((0.2, 0.3, 0.08), Roughness=0.6)
    for i in range(13):
        x, y, tall = rng.uniform(-3, 3), rng.uniform(-1.6, 3.2), rng.uniform(1.2, 2.6)
        bend = rng.uniform(-0.4, 0.4)
        line = [(x + bend * (j / 8) ** 2, y, tall * j / 8) for j in range(9)]
        wires([line], 0.022, stem)
        for point in line[2:]:
            blades([point] * 3, 0.5, 0.12, leaf, rng, 1.4)
        tint = ((0.8, 0.12, 0.1), (0.85, 0.6, 0.08), (0.5, 0.2, 0.6), (0.85, 0.8, 0.75))[i % 4]
        ball(surface((0.5, 0.3, 0.04), Roughness=0.8), line[-1], 0.07)
        blades([line[-1]] * 11, 0.26, 0.11, thin_cloth(tint, 0.4), rng, 2.2)
    reed = surface((0.45, 0.38, 0.2), Roughness=0.7)
    wires([[(x, y, 0), (x + a, y, 0.9 * h), (x + 2.2 * a, y + a, 1.6 * h)] for x, y, a, h in
           ((rng.uniform(-4, 4), rng.uniform(2, 4.5), rng.uniform(-0.2, 0.2), rng.uniform(0.8, 1.5)) for _ in range(90))], 0.012, reed, 4)
    sun((-4, -5, 6), 3.0)
    if view == 0:
        camera((0.3, -5.6, 1.9), (0, 1.2, 0.95), 36)
    else:
        camera((-3.2, -3.0, 1.3), (0.4, 1.4, 0.9), 38)


def room(view):
    """A bedroom in the evening: a lamp with a shade, small bulbs on a string, and light from a corridor through the door."""
    begin(0.45)
    rng = stream("room")
    surroundings(0.1, colour=(0.15, 0.25, 0.6))
    plaster = surface((0.72, 0.68, 0.6), Roughness=0.9)
    planks = surface(texture="wood", scale=1.5, colours=((0.3, 0.17, 0.08), (0.48, 0.3, 0.17)), stretch=(0.2, 2, 1), Roughness=0.4)
    box(planks, (0, 0, -0.1), (9, 9, 0.1))
    box(plaster, (0, 0, 2.8), (9, 9, 0.1))
    paper = surface(texture="noise", scale=2.5, colours=((0.45, 0.52, 0.5), (0.58, 0.62, 0.58)), Roughness=0.9)
    box(paper, (0, 2.55, 0), (5.2, 0.1, 2.8))
    box(paper, (-2.55, 0, 0), (0.1, 5.2, 2.8))
    box(plaster, (0, -2.65, 0), (5.2, 0.1, 2.8))
    box(plaster, (2.55, -1.0, 0), (0.1, 3.2, 2.8))  # the wall with the door
    box(plaster, (2.55, 2.1, 0), (0.1, 1.0, 2.8))
    box(plaster, (2.55, 1.1, 2.1), (0.1, 1.0, 0.7))
    box(plaster, (4.4, 2, 0), (0.1, 9, 2.8))
    box(plaster, (3.5, 4.4, 0), (2, 0.1, 2.8))
    white = surface((0.75, 0.74, 0.7), Roughness=0.35)
    box(white, (2.98, 0.66, 0.01), (0.9, 0.04, 2.05), (0, 0, 0.35))  # the door, ajar
    area((3.5, 1.4, 2.7), (3.1, 1.2, 0), 1.0, 600, (1, 0.93, 0.82))
    oak = surface(texture="wood", scale=1.6, colours=((0.4, 0.25, 0.13), (0.55, 0.38, 0.22)), stretch=(1.6, 0.3, 1.6), Roughness=0.4)
    box(oak, (-1.4, 1.6, 0), (1.6, 1.8, 0.32), bevel=0.03)
    box(surface((0.7, 0.68, 0.64), Roughness=0.95), (-1.4, 1.55, 0.32), (1.5, 1.75, 0.2), bevel=0.08)
    box(surface(texture="checker", scale=4, colours=((0.5, 0.12, 0.1), (0.62, 0.5, 0.38)), Roughness=0.95), (-1.4, 1.2, 0.36), (1.56, 1.1, 0.2), bevel=0.08)
    box(surface((0.75, 0.73, 0.68), Roughness=0.95), (-1.4, 2.2, 0.5), (0.8, 0.4, 0.18), bevel=0.08)
    box(oak, (-0.2, 2.15, 0), (0.5, 0.5, 0.55), bevel=0.02)
    lathe(((0, 0), (0.11, 0), (0.12, 0.03), (0.03, 0.07), (0.05, 0.18), (0.02, 0.3), (0.02, 0.34), (0, 0.35)), metal((0.85, 0.6, 0.35), 0.3), (-0.2, 2.15, 0.55))
    lathe(((0.19, 0.28), (0.12, 0.52)), thin_cloth((0.8, 0.66, 0.45), 0.6), (-0.2, 2.15, 0.55), rounded=False)
    bulb((-0.2, 2.15, 0.95), 80, 0.04)
    box(oak, (1.2, 2.35, 0), (1.5, 0.35, 0.06))
    for z in (0.5, 1.0, 1.5):
        box(oak, (1.2, 2.35, z), (1.5, 0.35, 0.04))
        x = 0.52
        while x < 1.75 and z < 1.5:
            thick, tall = rng.uniform(0.04, 0.09), rng.uniform(0.25, 0.38)
            tint = ((0.5, 0.1, 0.08), (0.1, 0.2, 0.4), (0.6, 0.5, 0.3), (0.12, 0.3, 0.18), (0.65, 0.62, 0.55))[rng.randrange(5)]
            box(surface(tint, Roughness=0.6), (x, 2.32, z + 0.04), (thick, 0.24, tall))
            x += thick + 0.012
    for x in (0.47, 1.93):
        box(oak, (x, 2.35, 0), (0.04, 0.35, 1.54))
    string = [(-2.3 + 0.25 * i, 2.46, 2.3 - 0.16 * math.sin(math.pi * (i % 6) / 6)) for i in range(19)]
    wires([string], 0.006, surface((0.1, 0.1, 0.1)))
    for point in string[1:-1:2]:
        spark(glowing((1, 0.65, 0.3), 170), point, 0.022)
    for x, tint in ((-1.6, (0.55, 0.3, 0.15)), (-0.7, (0.2, 0.35, 0.5))):
        box(surface((0.1, 0.07, 0.05), Roughness=0.4), (x, 2.48, 1.25), (0.62, 0.03, 0.72))
        box(surface(texture="noise", scale=3, colours=(tint, (0.8, 0.75, 0.6)), Roughness=0.6), (x, 2.465, 1.3), (0.5, 0.03, 0.6))
    shape("cylinder", surface(texture="rings", scale=2.2, colours=((0.5, 0.42, 0.3), (0.25, 0.12, 0.1)), Roughness=1.0), (0.5, 0.3, 0.012), radius=0.95,
          depth=0.024)
    lathe(((0, 0), (0.2, 0), (0.22, 0.05), (0.27, 0.4), (0.24, 0.42), (0, 0.38)), white, (1.95, -0.2, 0))
    blades([(1.95, -0.2, 0.38)] * 26, 0.75, 0.07, thin_cloth((0.1, 0.28, 0.08), 0.4), rng, 1.1)
    ball(metal((0.8, 0.8, 0.82), 0.1), (0.9, -0.2, 0.17), 0.17)
    if view == 0:
        camera((0.5, -2.4, 1.4), (0.2, 1.6, 0.9), 26)
    else:
        camera((-2.0, -1.5, 1.3), (0.8, 1.5, 0.85), 28)


def metals(view):
    """Balls, gears, pipes, pans and a crumpled foil of many roughnesses on dark marble."""
    begin(0.75)
    rng = stream("metals")
    surroundings(0.9, "studio", 0.8)
    floor(surface(texture="marble", scale=0.3, colours=((0.1, 0.1, 0.11), (0.42, 0.4, 0.38)), Roughness=0.15))
    wall(surface((0.5, 0.42, 0.34), Roughness=0.6), (0, 6, 0), 80, 14)
    gold, copper, steel, brass = (0.98, 0.7, 0.3), (0.9, 0.45, 0.3), (0.62, 0.63, 0.66), (0.85, 0.65, 0.28)
    for i in range(12):
        size = rng.uniform(0.25, 0.62)
        x, y = -3.6 + 2.4 * (i % 4) + rng.uniform(-0.4, 0.4), -1.8 + 1.9 * (i // 4) + rng.uniform(-0.3, 0.3)
        ball(metal((gold, copper, steel, brass)[i % 4], (0.02, 0.12, 0.22, 0.35, 0.5)[i % 5]), (x, y, size), size)
    for i, (x, y, turn) in enumerate(((-0.7, -2.4, (0, 0, 0)), (0.9, 0.1, (1.25, 0.2, 0.5)))):
        ring = shape("cylinder", metal((steel, brass)[i], 0.28), (x, y, 0.16 + 0.62 * i), radius=0.6, depth=0.3, turn=turn, vertices=64)
        for k in range(14):
            angle = 2 * math.pi * k / 14
            tooth = box(metal((steel, brass)[i], 0.28), (0, 0, 0), (0.2, 0.14, 0.3), bevel=0.02)
            tooth.parent, tooth.location, tooth.rotation_euler = ring, (0.66 * math.cos(angle), 0.66 * math.sin(angle), 0), (0, 0, angle)
    for i in range(5):
        shape("torus", metal((copper, gold, steel)[i % 3], 0.08 + 0.08 * i), (-2.6 + 1.4 * i, 2.6 - 0.3 * (i % 2), 0.2 + 0.55 * (i % 2)),
              turn=(1.3 * (i % 2), 0.3, 0.4 * i), major_radius=0.6, minor_radius=0.18, major_segments=96, minor_segments=32)
    spiral = [(2.7 + 0.55 * math.cos(t / 6), -1.5 + 0.55 * math.sin(t / 6), 0.1 + 0.011 * t) for t in range(150)]
    wires([spiral], 0.07, metal(copper, 0.2), 12)
    pan = ((0, 0), (0.8, 0), (1.0, 0.12), (1.1, 0.6), (1.05, 0.6), (0.94, 0.16), (0.78, 0.06), (0, 0.05))
    lathe(pan, metal(steel, 0.3, Anisotropic=0.7), (-2.9, 0.4, 0.55), turn=(0.9, 0, 0.4))
    lathe(((0, 0), (0.4, 0), (0.15, 0.15), (0.1, 0.9), (0.35, 1.3), (0.5, 1.9), (0.45, 1.9), (0.3, 1.35), (0, 1.25)), metal(gold, 0.15), (1.0, 2.2, 0))
    shape("ico_sphere", metal((0.75, 0.76, 0.78), 0.18), (0.2, -1.0, 0.42), smooth=False, radius=0.45, subdivisions=2)
    box(surface((0.5, 0.05, 0.06), Roughness=0.1, Coat_Weight=1.0, Metallic=0.6), (3.5, 1.0, 0), (0.9, 0.9, 0.9), (0, 0, 0.4), 0.08)
    area((-4, -4, 6), (0, 0, 0), 2.2, 700, (1, 0.93, 0.82))
    area((5, -1, 4), (0, 0, 0.5), 1.2, 350, (0.8, 0.9, 1), height=3)
    if view == 0:
        camera((0.2, -7.4, 3.4), (0, 0, 0.5), 40)
    else:
        camera((-5.2, -4.4, 2.0), (0.2, 0.4, 0.6), 40)
