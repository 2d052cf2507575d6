"""Photographs of quadrant targets on a wall, the COLMAP model of them in a frame of its own, and the survey: what colmap_targets takes."""
import math
import random
import struct
import zlib

WIDTH, HEIGHT, FOCAL, SCALE = 640, 480, 600.0, 0.25
TARGETS = {f"Q{i}{k}": (0.5 * i, 0.02 * ((i * k) % 3), 0.4 * k) for i in range(4) for k in range(3)}
CENTRES = [(0.1, -2.0, 0.3), (0.7, -2.2, 0.6), (1.3, -2.0, 0.2), (0.8, -1.7, 0.4)]
LOOKS_AT = (0.75, 0.0, 0.4)


def rotation(centre):
    """Rows: right, down and forward of a camera that looks at the middle of the wall, z up."""
    forward = [a - b for a, b in zip(LOOKS_AT, centre)]
    norm = math.hypot(*forward)
    z = [c / norm for c in forward]
    flat = math.hypot(z[0], z[1])
    x = [z[1] / flat, -z[0] / flat, 0.0]
    y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
    return [x, y, z]


def seen(point, centre):
    """The pixel of a point, first pixel centre (0.5, 0.5) as COLMAP has it."""
    x, y, z = ([sum(r * (p - c) for r, p, c in zip(row, point, centre)) for row in rotation(centre)])
    return FOCAL * x / z + WIDTH / 2, FOCAL * y / z + HEIGHT / 2


def quaternion(m):
    w = math.sqrt(max(0.0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2
    return w, (m[2][1] - m[1][2]) / (4 * w), (m[0][2] - m[2][0]) / (4 * w), (m[1][0] - m[0][1]) / (4 * w)


def painted(centre):
    """Rows of grey values: quadrants of 14 px about each target, edges blurred over a pixel."""
    rows = [bytearray([128]) * WIDTH for _ in range(HEIGHT)]
    for point in TARGETS.values():
        u, v = seen(point, centre)
        right, up = (seen((point[0] + d[0], point[1], point[2] + d[1]), centre) for d in ((0.03, 0), (0, 0.03)))
        (a, c), (b, d) = ((p[0] - u, p[1] - v) for p in (right, up))
        det = a * d - b * c
        for y in range(int(v) - 14, int(v) + 15):
            for x in range(int(u) - 14, int(u) + 15):
                du, dv = x + 0.5 - u, y + 0.5 - v
                if math.hypot(du, dv) < 13:
                    along, across = (d * du - b * dv) / det * 8, (a * dv - c * du) / det * 8
                    rows[y][x] = round(128 + 90 * math.tanh(1.5 * along) * math.tanh(1.5 * across))
    return rows


def png(rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"".join(b"\0" + bytes(r) for r in rows))) + chunk(b"IEND", b"")


def write(folder):
    """painted/ (photographs), painted_model/ (COLMAP's text), painted.csv (the survey), pointed.csv (four targets, by hand)."""
    dice = random.Random(1)
    for name in ("painted", "painted_model"):
        (folder / name).mkdir()
    ties = [(dice.uniform(0, 1.5), dice.uniform(-0.1, 0.3), dice.uniform(0, 0.8)) for _ in range(60)]
    images, tracks = [], [[] for _ in ties]
    for number, centre in enumerate(CENTRES, 1):
        (folder / "painted" / f"p{number}.png").write_bytes(png(painted(centre)))
        turn = rotation(centre)
        shift = [-SCALE * sum(r * c for r, c in zip(row, centre)) for row in turn]
        images.append(f"{number} {' '.join(map(repr, quaternion(turn)))} {' '.join(map(repr, shift))} 1 p{number}.png")
        places = []
        for k, tie in enumerate(ties):
            u, v = seen(tie, centre)
            tracks[k].append((number, k))
            places.append(f"{u + dice.gauss(0, 0.2)} {v + dice.gauss(0, 0.2)} {k + 1}")
        images.append(" ".join(places))
    (folder / "painted_model/cameras.txt").write_text(f"1 PINHOLE {WIDTH} {HEIGHT} {FOCAL} {FOCAL} {WIDTH / 2} {HEIGHT / 2}\n")
    (folder / "painted_model/images.txt").write_text("\n".join(images) + "\n")
    (folder / "painted_model/points3D.txt").write_text("".join(
        f"{k + 1} {' '.join(repr(SCALE * c) for c in tie)} 128 128 128 0.2 {' '.join(f'{i} {p}' for i, p in tracks[k])}\n" for k, tie in enumerate(ties)))
    (folder / "painted.csv").write_text("name,x,y,z\n" + "".join(f"{n},{x},{y},{z}\n" for n, (x, y, z) in TARGETS.items()))
    corners = ("Q00", "Q30", "Q02", "Q32")
    (folder / "pointed.csv").write_text("image,point,x,y\n" + "".join(
        f"p{number}.png,{name},{u + dice.uniform(-2, 2):.1f},{v + dice.uniform(-2, 2):.1f}\n"
        for number, centre in enumerate(CENTRES, 1) for name in corners for u, v in [seen(TARGETS[name], centre)]))
