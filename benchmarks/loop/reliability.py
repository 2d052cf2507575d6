#!/usr/bin/env python3
"""The reliability diagram of p_in as an SVG: probabilities that the gate stated beside the shares found inside.

usage: reliability.py OUT.svg RESULT.txt ...     results of loop_benchmark, with tighter and wider tolerances
"""
import math
import re
import sys

SIZE, LEFT, BOTTOM, TOP = 420, 60, 370, 20
SCALE = (BOTTOM - TOP)


def bins_of(paths):
    """Lines "stated found [low, high] panels" after the heading of p_in, of all files, by tenths of what was stated."""
    bins = {}
    for path in paths:
        text = open(path, encoding="utf-8").read().split("p_in: stated", 1)[1]
        for stated, found, panels in re.findall(r"^ +([\d.]+) ([\d.]+) \[[^]]*\] (\d+)$", text, re.M):
            stated, found, panels = float(stated), float(found), int(panels)
            at = bins.setdefault(10 if stated >= 0.95 else int(10 * stated), [0.0, 0.0, 0])
            at[0] += stated * panels
            at[1] += found * panels
            at[2] += panels
    return [(s / n, f / n, n) for _, (s, f, n) in sorted(bins.items())]


def wilson(p, n, z=1.96):
    d = 1 + z * z / n
    half = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / d
    middle = (p + z * z / (2 * n)) / d
    return middle - half, middle + half


def main(out, paths):
    x = lambda p: LEFT + SCALE * p
    y = lambda p: BOTTOM - SCALE * p
    text = lambda px, py, words, anchor="middle": f'<text x="{px:.0f}" y="{py:.0f}" text-anchor="{anchor}">{words}</text>'
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE + 30} {SIZE}" font-family="sans-serif" font-size="12">',
             '<rect width="100%" height="100%" fill="white"/>',
             f'<path d="M{x(0)} {y(0)}L{x(1)} {y(1)}" stroke="#999" stroke-dasharray="4 4"/>']
    for tick in (0, 0.2, 0.4, 0.6, 0.8, 1):
        parts.append(f'<path d="M{x(tick):.0f} {BOTTOM}V{TOP}M{LEFT} {y(tick):.0f}H{x(1):.0f}" stroke="#ddd"/>')
        parts += [text(x(tick), BOTTOM + 18, f"{tick:.1f}"), text(LEFT - 8, y(tick) + 4, f"{tick:.1f}", "end")]
    for stated, found, panels in bins_of(paths):
        low, high = wilson(found, panels)
        parts.append(f'<path d="M{x(stated):.1f} {y(low):.1f}V{y(high):.1f}" stroke="#0072b2" stroke-width="2"/>')
        parts.append(f'<circle cx="{x(stated):.1f}" cy="{y(found):.1f}" r="4" fill="#0072b2"><title>stated {stated:.3f}, found {found:.3f} of {panels}</title></circle>')
        print(f"{stated:.3f} {found:.3f} [{low:.3f}, {high:.3f}] {panels}")
    parts += [text(x(0.5), BOTTOM + 38, "p stated by the gate"),
              f'<text transform="translate(16 {y(0.5):.0f}) rotate(-90)" text-anchor="middle">share found inside</text>', "</svg>"]
    open(out, "w", encoding="utf-8").write("\n".join(parts) + "\n")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2:])
