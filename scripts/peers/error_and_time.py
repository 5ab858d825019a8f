"""For error_and_time.sh: one table of all that `ld_bench tradeoff` measured, and one picture of it, OUT/error_and_time.svg."""
import json
import math
import sys
from pathlib import Path
from xml.sax.saxutils import escape

SIZES, SAMPLES = ("small", "large"), (2, 8, 32)
WIDTH, HEIGHT, LEFT, TOP, GAP = 300, 190, 60, 46, 56
COLOURS = (("oidn", "#d1495b"), ("common_fine", "#1b6ca8"), ("pyramid_fine", "#6a4c93"), ("common_fast", "#2a9d6f"), ("svgf", "#8a6d3b"), ("eaw", "#b59a5b"))


def colour(name):
    return next((value for prefix, value in COLOURS if name.startswith(prefix)), "#444444")


def mark(name, x, y):
    """Open Image Denoise: diamonds; fitted weights: filled; 8 bits: small."""
    r = 3.5 if name.endswith("_i8") else 5.5
    fill = colour(name) if "fitted" in name else "#ffffff"
    style = f'fill="{fill}" stroke="{colour(name)}" stroke-width="1.8"'
    if name.startswith("oidn"):
        return f'<path d="M{x - r:.1f} {y:.1f} L{x:.1f} {y - r:.1f} L{x + r:.1f} {y:.1f} L{x:.1f} {y + r:.1f} Z" {style}/>'
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r}" {style}/>'


def ticks(low, high, steps):
    decade = 10 ** math.floor(math.log10(low))
    while decade <= high:
        for step in steps:
            if low <= step * decade <= high:
                yield step * decade
        decade *= 10


def panel(table, left, top, corner):
    points = [point for point in table["points"] if not point["name"].startswith("eaw")]  # far above the others
    xs, ys = [point["ms"] for point in points], [point["scores"]["smape"] for point in points]
    x0, x1, y0, y1 = min(xs) / 1.4, max(xs) * 1.4, min(ys) / 1.04, max(ys) * 1.04
    def across(ms):
        return left + WIDTH * math.log(ms / x0) / math.log(x1 / x0)
    def down(error):
        return top + HEIGHT * (1 - math.log(error / y0) / math.log(y1 / y0))
    yield f'<rect x="{left}" y="{top}" width="{WIDTH}" height="{HEIGHT}" fill="#fafafa" stroke="#bbbbbb"/>'
    yield f'<text x="{left + 4}" y="{top - 6}" font-weight="bold">{escape(corner)}</text>'
    for tick in ticks(x0, x1, (1, 2, 5)):
        yield f'<text x="{across(tick):.1f}" y="{top + HEIGHT + 15}" text-anchor="middle" fill="#555555">{tick:g}</text>'
        yield f'<path d="M{across(tick):.1f} {top} v{HEIGHT}" stroke="#e6e6e6"/>'
    for tick in ticks(y0, y1, (1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)):
        yield f'<text x="{left - 5}" y="{down(tick) + 4:.1f}" text-anchor="end" fill="#555555">{tick:.3g}</text>'
        yield f'<path d="M{left} {down(tick):.1f} h{WIDTH}" stroke="#e6e6e6"/>'
    for point in points:
        yield mark(point["name"], across(point["ms"]), down(point["scores"]["smape"]))


def picture(tables):
    rows = [(size, [(samples, tables[size, samples]) for samples in SAMPLES if (size, samples) in tables]) for size in SIZES]
    width, height = LEFT + 3 * (WIDTH + GAP), TOP + 2 * (HEIGHT + GAP) + 24
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" font-family="sans-serif" '
             f'font-size="12"><rect width="{width}" height="{height}" fill="#ffffff"/>',
             f'<text x="{LEFT}" y="18" font-size="14" font-weight="bold">SMAPE against ms a frame: lower and further left is better</text>']
    for row, (_, panels) in enumerate(rows):
        for column, (samples, table) in enumerate(panels):
            lines += panel(table, LEFT + column * (WIDTH + GAP), TOP + row * (HEIGHT + GAP), f'{table["width"]}x{table["height"]}, {samples} spp')
    x, y = LEFT, height - 12
    for name, text in (("oidn", "Open Image Denoise, 3 qualities"), ("common_fine", "common_fine"), ("pyramid_fine", "pyramid_fine"), ("common_fast", "common_fast"),
                       ("common_fine_fitted", "fitted to the shot"), ("common_fine_i8", "in 8 bits"), ("svgf", "SVGF")):
        lines += [mark(name, x + 6, y - 4), f'<text x="{x + 16}" y="{y}">{text}</text>']
        x += 40 + 7 * len(text)
    return "\n".join([*lines, "</svg>", ""])


def main():
    out = Path(sys.argv[1])
    tables = {(size, samples): json.loads((out / f"{size}.{samples}.json").read_text()) for size in SIZES for samples in SAMPLES
              if (out / f"{size}.{samples}.json").exists()}
    for size in SIZES:
        found = [tables[size, samples] for samples in SAMPLES if (size, samples) in tables]
        first = found[0]
        print(f'\n{first["width"]}x{first["height"]}, {first["frames"]} frames, {first["threads"]} threads; SMAPE, relMSE and ms a frame:\n')
        print("| method | " + " | ".join(f"{table['spp']} spp" for table in found) + " |\n| :--- |" + " ---: |" * len(found))
        print("| noisy | " + " | ".join(f"{table['noisy']['smape']:.4f} {table['noisy']['relmse']:.4f}" for table in found) + " |")
        for number, point in enumerate(first["points"]):
            cells = [table["points"][number] for table in found]
            print(f"| {point['name']} | " + " | ".join(f"{c['scores']['smape']:.4f} {c['scores']['relmse']:.4f} {c['ms']:.1f}" for c in cells) + " |")
    (out / "error_and_time.svg").write_text(picture(tables))


if __name__ == "__main__":
    main()
