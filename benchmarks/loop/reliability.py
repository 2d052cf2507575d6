#!/usr/bin/env python3
"""The reliability diagram of p_in as an SVG: probabilities that the gate stated beside the shares found inside.

usage: reliability.py OUT.svg RESULT.txt ...     results of loop_benchmark, with tighter and wider tolerances

Two intervals of 95 % each: the binomial one (Wilson 1927), as if panels were independent, and one whose unit is the tower
(linearised ratio, Cochran 1977, section 6.3, on the logit scale, Student's t), because panels of a tower share its survey. A seed is one
tower, whatever the tolerance.
"""
import math
import re
import sys

SIZE, LEFT, BOTTOM, TOP = 420, 60, 370, 20
SCALE = (BOTTOM - TOP)


def towers_of(paths):
    """Of each bin, by seed: panels, sum of what was stated, panels inside."""
    bins = {}
    for path in paths:
        for seed, which, panels, stated, inside in re.findall(
                r"^tower (\d+) (\d+) (\d+) ([\d.]+) (\d+)$", open(path, encoding="utf-8").read(), re.M):
            at = bins.setdefault(int(which), {}).setdefault(int(seed), [0, 0.0, 0])
            at[0] += int(panels)
            at[1] += float(stated)
            at[2] += int(inside)
    return [list(by_seed.values()) for _, by_seed in sorted(bins.items())]


def wilson(p, n, z=1.96):
    d = 1 + z * z / n
    half = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / d
    middle = (p + z * z / (2 * n)) / d
    return middle - half, middle + half


def student(freedom):
    """97.5 % quantile of Student's t, by Cornish and Fisher's expansion: to 0.01 from 5 degrees of freedom on."""
    z, f = 1.959964, freedom
    return z + (z**3 + z) / (4 * f) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * f * f) + (
        3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * f**3)


def by_tower(towers):
    """Interval of the share of panels inside; None of fewer than six towers, or where all or none are inside."""
    n, k, m = sum(t[0] for t in towers), sum(t[2] for t in towers), len(towers)
    p = k / n
    if m < 6 or k in (0, n):
        return None
    variance = m / (m - 1) * sum((t[2] - p * t[0])**2 for t in towers) / n**2
    half = student(m - 1) * math.sqrt(variance) / (p * (1 - p))
    middle = math.log(p / (1 - p))
    return tuple(1 / (1 + math.exp(-(middle + s * half))) for s in (-1, 1))


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
    print("stated found   binomial          by tower          panels towers")
    for towers in towers_of(paths):
        panels = sum(t[0] for t in towers)
        stated, found = sum(t[1] for t in towers) / panels, sum(t[2] for t in towers) / panels
        low, high = wilson(found, panels)
        both = by_tower(towers)
        if both:
            parts.append(f'<path d="M{x(stated):.1f} {y(both[0]):.1f}V{y(both[1]):.1f}" stroke="#9ecae1" stroke-width="6"/>')
        parts.append(f'<path d="M{x(stated):.1f} {y(low):.1f}V{y(high):.1f}" stroke="#0072b2" stroke-width="2"/>')
        parts.append(f'<circle cx="{x(stated):.1f}" cy="{y(found):.1f}" r="4" fill="#0072b2"><title>stated {stated:.3f}, found {found:.3f} of {panels}</title></circle>')
        wide = f"[{both[0]:.3f}, {both[1]:.3f}]" if both else "-" * 14
        print(f"{stated:.3f}  {found:.3f}  [{low:.3f}, {high:.3f}]  {wide}  {panels:6d} {len(towers):6d}")
    parts += [text(x(0.5), BOTTOM + 38, "p stated by the gate"),
              f'<text transform="translate(16 {y(0.5):.0f}) rotate(-90)" text-anchor="middle">share found inside</text>', "</svg>"]
    open(out, "w", encoding="utf-8").write("\n".join(parts) + "\n")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2:])
