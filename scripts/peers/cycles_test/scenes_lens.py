"""Scenes with defocus or motion blur. Each function builds everything, its camera for `view` 0 or 1 included."""
import math

from kit import (area, ball, begin, box, camera, floor, lathe, model, move, shape, shutter, spark, stream, sun, surroundings, wall,
                 wires)
from surfaces import glass, glowing, metal, surface

WOOD = dict(texture="wood", scale=1.2, colours=((0.36, 0.18, 0.08), (0.62, 0.38, 0.2)), stretch=(0.25, 1.6, 1))
APPLE = ((0, 0.12), (0.25, 0.02), (0.55, 0.12), (0.78, 0.5), (0.82, 0.85), (0.65, 1.2), (0.35, 1.34), (0.1, 1.24), (0, 1.12))
PEAR = ((0, 0), (0.35, 0.03), (0.68, 0.35), (0.72, 0.7), (0.5, 1.1), (0.33, 1.5), (0.26, 1.75), (0.12, 1.88), (0, 1.88))
BOTTLE = ((0, 0.1), (0.5, 0.05), (0.62, 0.12), (0.64, 0.4), (0.64, 1.9), (0.58, 2.25), (0.28, 2.65), (0.22, 2.9), (0.22, 3.5), (0.27, 3.52),
          (0.27, 3.66), (0.2, 3.68))


def still_life(view):
    """Fruit, bottle and bowl on a table by a window, small lights far behind: a wide lens."""
    begin(0.7)
    rng = stream("still life")
    surroundings(0.45, "interior", 2.0)
    box(surface(Roughness=0.35, **WOOD), (0, 0, -0.4), (11, 6, 0.4), bevel=0.05)
    wall(surface(texture="noise", scale=0.5, colours=((0.16, 0.2, 0.24), (0.3, 0.33, 0.34)), Roughness=0.8), (0, 9, -3), 40, 16)
    skin = dict(texture="noise", scale=1.5, Roughness=0.3, Coat_Weight=0.4)
    places = ((-1.9, -0.9), (-0.6, -1.7), (1.0, 0.1), (2.6, 1.0), (-3.2, 1.2))
    tints = (((0.5, 0.03, 0.03), (0.7, 0.3, 0.08)), ((0.55, 0.45, 0.06), (0.4, 0.5, 0.1)), ((0.55, 0.06, 0.03), (0.45, 0.02, 0.04)),
             ((0.3, 0.45, 0.08), (0.6, 0.5, 0.12)), ((0.6, 0.12, 0.04), (0.75, 0.5, 0.15)))
    stalk = surface((0.15, 0.09, 0.04), Roughness=0.7)
    for i, ((x, y), colours) in enumerate(zip(places, tints)):
        profile = PEAR if i in (1, 3) else APPLE
        lathe(profile, surface(colours=colours, stretch=(1, 1, 0.3), seed=i, **skin), (x, y, 0), turn=(0.1 * (i % 2), 0.05 * i, i))
        top = profile[-1][1]
        wires([[(x, y, top - 0.1), (x + 0.03, y, top + 0.2), (x + 0.12, y - 0.02, top + 0.42)]], 0.045, stalk)
    lathe(BOTTLE, glass((0.5, 0.85, 0.55)), (-1.2, 1.6, 0))
    shell = ((0, 0.12), (0.5, 0.1), (0.6, 0), (0.7, 0.02), (1.3, 0.55), (1.65, 1.15), (1.58, 1.18), (1.2, 0.65), (0.5, 0.25), (0, 0.22))
    lathe(shell, surface((0.75, 0.78, 0.8), Roughness=0.15, Coat_Weight=0.5), (2.0, 2.4, 0))
    for i in range(9):
        angle = i * 2.4
        ball(surface((0.75, 0.28 + 0.03 * (i % 4), 0.04), Roughness=0.45), (2.0 + 0.75 * math.cos(angle) * (i > 0), 2.4 + 0.75 * math.sin(angle)
             * (i > 0), 0.9 + 0.25 * (i % 3 == 0)), 0.42)
    for i in range(14):  # grapes
        ball(surface((0.16, 0.03, 0.14), Roughness=0.25, Coat_Weight=0.3),
             (0.55 + rng.uniform(-0.55, 0.55), -2.0 + rng.uniform(-0.3, 0.3), 0.22 + 0.34 * (i % 3 == 0)), 0.22)
    for i in range(26):
        tint = ((1, 0.6, 0.25), (1, 0.8, 0.5), (0.5, 0.7, 1))[i % 3]
        spark(glowing(tint, 14), (rng.uniform(-9, 9), rng.uniform(7.0, 8.6), rng.uniform(0.5, 6)), 0.09)
    area((-7, -3, 6), (0, 0, 0.5), 4, 1300, (1, 0.95, 0.88), height=5)
    if view == 0:
        camera((0.6, -9, 3.1), (-0.1, 0, 1.0), 52, (-0.6, -1.7, 0.8), 0.075)
    else:
        camera((-5.2, -6.2, 1.7), (0.3, 0.6, 0.9), 60, (1.2, 1.2, 0.9), 0.07)


def models(view, data):
    """Meshes of the package pybullet_data on a desk, near and far: a wide lens."""
    begin(0.9)
    surroundings(0.8, "courtyard", 0.6)
    box(surface(Roughness=0.3, texture="wood", scale=1.0, colours=((0.3, 0.17, 0.09), (0.5, 0.31, 0.17)), stretch=(1.4, 0.2, 1)),
        (0, 2, -0.3), (16, 12, 0.3), bevel=0.05)
    wall(surface(texture="brick", scale=0.9, colours=((0.3, 0.36, 0.4), (0.38, 0.42, 0.44), (0.2, 0.2, 0.2)), bump=-0.4), (0, 8, -1), 40, 14)
    model(data / "duck.obj", surface(picture=data / "duckCM.png", Roughness=0.35), (-1.3, -0.8, 0), 2.0, (0, 0, 0.7), "y")
    model(data / "teddy2_VHACD_CHs.obj", surface(texture="noise", scale=5, colours=((0.33, 0.17, 0.07), (0.55, 0.33, 0.16)), Roughness=0.9,
                                                 Sheen_Weight=0.4), (1.9, 1.3, 0), 2.8, (0, 0, 2.6), "y")
    model(data / "objects/mug.obj", surface((0.1, 0.28, 0.5), Roughness=0.2, Coat_Weight=0.6), (0.7, -1.7, 0), 1.2, (0, 0, 0.5))
    model(data / "soccerball.obj", surface((0.8, 0.8, 0.78), texture="checker", scale=1.6, colours=((0.85, 0.85, 0.82), (0.06, 0.06, 0.07)),
                                           Roughness=0.3), (-2.7, 2.6, 0), 2.2)
    model(data / "bunny.obj", surface((0.85, 0.8, 0.72), Roughness=0.25, Subsurface_Weight=0.0), (0.2, 4.2, 0), 2.4, (0, 0, 0.5), "y")
    for i in range(7):
        model(data / "lego/lego.obj", surface(((0.7, 0.05, 0.04), (0.8, 0.55, 0.04), (0.05, 0.2, 0.6), (0.06, 0.4, 0.1))[i % 4], Roughness=0.25),
              ((-0.3, 2.4, 3.3, 2.7, -3.4, 3.9, -2.6)[i], (-2.5, -1.1, -0.4, -1.9, 0.2, 2.9, -1.6)[i], 0), 0.75, (0, 0, i * 1.3))
    for i in range(8):
        turn = (math.pi / 2 if i < 7 else 0, 0, 0.25 * i)
        model(data / "domino/domino.obj", surface(picture=data / "domino/domino.jpg", Roughness=0.25),
              (-4.2 + 0.5 * i, 4.6 - 0.16 * i * i + 0.9 * i, 0), 1.0, turn)
    area((6, -5, 7), (0, 0, 0), 3, 1100, (1, 0.9, 0.78))
    if view == 0:
        camera((0.2, -8.6, 2.9), (0, 0, 0.8), 46, (-1.3, -1.0, 0.9), 0.075)
    else:
        camera((-4.6, -5.8, 2.3), (0.6, 1.2, 0.9), 50, (1.7, 1.0, 1.2), 0.065)


def toys(view):
    """A playroom: a pinwheel and a top that turn, balls and a wagon that move, blocks that stand still."""
    begin(0.55)
    surroundings(0.5, "studio", 1.0)
    floor(surface(texture="checker", scale=0.8, colours=((0.62, 0.56, 0.46), (0.4, 0.34, 0.28)), Roughness=0.4))
    wall(surface(texture="noise", scale=1.2, colours=((0.35, 0.5, 0.55), (0.5, 0.62, 0.6)), Roughness=0.7), (0, 5, 0), 60, 12)
    paint = [surface(colour, Roughness=0.3, Coat_Weight=0.3) for colour in
             ((0.7, 0.06, 0.05), (0.85, 0.55, 0.05), (0.05, 0.25, 0.6), (0.08, 0.45, 0.15), (0.75, 0.72, 0.68))]
    for i, (x, y, z) in enumerate(((-3.4, 2.6, 0), (-2.3, 2.9, 0), (-2.9, 2.7, 1), (3.2, 3, 0), (3.9, 1.6, 0))):
        box(paint[i], (x, y, z), (1, 1, 1), (0, 0, 0.3 * i), 0.06)
    pole = (0.9, 2.2, 2.9)
    wires([[(pole[0], pole[1] + 0.1, 0), (pole[0], pole[1] + 0.1, pole[2])]], 0.07, surface((0.7, 0.68, 0.6), Roughness=0.5))
    vanes = shape("cylinder", paint[4], pole, radius=0.16, depth=0.3, turn=(math.pi / 2, 0, 0))
    for i in range(4):
        vane = box(paint[i], (0, 0, 0), (0.55, 1.25, 0.06), bevel=0.02)
        vane.parent = vanes
        vane.location = (0.75 * math.cos(i * math.pi / 2), 0.75 * math.sin(i * math.pi / 2), 0)
        vane.rotation_euler = (0.35, 0, i * math.pi / 2 - math.pi / 2)
    move(vanes, turn=(0, 1.5, 0), steps=5)
    top = lathe(((0, 0), (0.08, 0.1), (0.5, 0.6), (0.75, 0.8), (0.7, 0.95), (0.15, 1.05), (0.09, 1.2), (0.09, 1.6), (0, 1.62)),
                surface(texture="checker", scale=2.2, colours=((0.8, 0.1, 0.08), (0.9, 0.8, 0.3)), Roughness=0.2), (-0.9, -0.7, 0),
                turn=(0.12, 0.1, 0))
    move(top, turn=(0, 0, 2.4), steps=5)
    stripes = surface(texture="rings", scale=1.5, colours=((0.1, 0.3, 0.75), (0.85, 0.85, 0.8)), Roughness=0.25)
    move(ball(stripes, (1.9, -0.4, 1.6), 0.62), (1.5, 0.3, 0.9), (0.3, 1.3, 0))
    move(ball(surface((0.75, 0.5, 0.06), Roughness=0.3), (-2.3, 0.6, 0.45), 0.45), (1.1, -0.4, 0), (0, 2.4, 0))
    wagon = move(box(paint[0], (3.0, 1.0, 0.3), (1.6, 0.9, 0.6), bevel=0.05), (-1.2, 0, 0))
    for x, y in ((-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)):
        wheel = shape("cylinder", paint[1], (x, y, -0.3), radius=0.3, depth=0.14, turn=(math.pi / 2, 0, 0))
        wheel.parent = wagon
    area((-4, -4, 7), (0, 0, 0), 3.5, 1200, (1, 0.94, 0.86))
    shutter(0.7)
    if view == 0:
        camera((0.3, -8.2, 3.0), (0.2, 0.5, 1.25), 42)
    else:
        view = camera((5.4, -5.4, 2.0), (0.3, 0.6, 1.1), 40)
        move(view, (-0.35, -0.3, 0.1))


def falling(view, data):
    """Toy bricks, dominoes and coins that fall on a garden table, seen by a camera that follows; view 1 also has a wide lens."""
    begin(0.8)
    rng = stream("falling")
    surroundings(0.8, "forest", 0.5)
    floor(surface(texture="noise", scale=1.5, colours=((0.08, 0.13, 0.04), (0.2, 0.25, 0.1)), Roughness=0.9), 60, -3)
    for i in range(9):
        box(surface(Roughness=0.5, seed=i, texture="wood", scale=1.5, colours=((0.3, 0.2, 0.13), (0.48, 0.36, 0.25)), stretch=(0.25, 1.6, 1)),
            (0, -3.4 + 1.0 * i, -0.2), (12, 0.92, 0.2), bevel=0.04)
    tints = ((0.7, 0.05, 0.04), (0.85, 0.6, 0.04), (0.05, 0.2, 0.65), (0.06, 0.42, 0.12), (0.8, 0.8, 0.78))
    for i in range(16):
        brick = model(data / "lego/lego.obj", surface(tints[i % 5], Roughness=0.2), (rng.uniform(-3, 3), rng.uniform(-1.5, 2.5), 0), 0.85,
                      (0, 0, rng.uniform(0, 6)))
        if i < 9:  # the others lie
            brick.location.z = 0.7 + 0.38 * i
            brick.rotation_euler = [rng.uniform(0, 6) for _ in range(3)]
            move(brick, (rng.uniform(-0.3, 0.3), 0, -rng.uniform(0.4, 1.1)), [rng.uniform(-1, 1) for _ in range(3)])
    for i in range(6):
        tile = model(data / "domino/domino.obj", surface(picture=data / "domino/domino.jpg", Roughness=0.2), (-3.3 + 0.75 * i, -2.3, 0), 1.3,
                     (0, 0, 0))
        tile.rotation_euler = (0, 1.1 - 0.22 * i, 0.2)
        tile.location.z = 0.25
        if i < 4:
            move(tile, (0.1, 0, -0.05), (0, 0.5, 0))
    for i in range(8):
        coin = shape("cylinder", metal((0.95, 0.7, 0.35), 0.18), (rng.uniform(-2.5, 2.8), rng.uniform(-2, 1), 1.2 + 0.35 * i), radius=0.36, depth=0.07,
                     turn=(i, 0.5 * i, 0))
        move(coin, (0, 0, -0.8), (1.8, 0.4, 0), 5)
    move(model(data / "soccerball.obj", surface(texture="checker", scale=1.6, colours=((0.85, 0.85, 0.82), (0.06, 0.06, 0.07)), Roughness=0.3),
               (2.3, 3.0, 0), 1.9), (0.7, -0.2, 0), (0, 0.7, 0))
    sun((5, -3, 6), 2.6)
    area((-6, -4, 6), (0, 0, 1), 4, 500, (0.85, 0.92, 1))
    shutter(0.6)
    if view == 0:
        move(camera((0.4, -9.2, 3.6), (0, 0, 1.35), 40), (0.15, 0, -0.15))
    else:
        move(camera((-5.6, -6.4, 2.6), (0.2, 0.3, 1.5), 44, (-0.2, -0.4, 1.2), 0.11), (0.25, -0.2, 0))
