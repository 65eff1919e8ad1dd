#!/usr/bin/env python3
"""Makes the pictures beside this file, and prints the measures that the tests expect of them.

Needs numpy and OpenEXR; the measures are computed here, by numpy, from the files as read back.
"""
import os

import numpy as np
import OpenEXR

os.chdir(os.path.dirname(os.path.abspath(__file__)))
W, H = 40, 30


def write_exr(name, picture):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    channels = {c: np.ascontiguousarray(picture[..., i]) for i, c in enumerate("RGB")}
    OpenEXR.File(header, channels).write(name)


def read_exr(name):
    channels = OpenEXR.File(name).channels()
    return np.array(channels["RGB"].pixels, np.float64)


def write_hdr(name, picture, exposure):
    """Flat RGBE, mantissas truncated."""
    p = np.asarray(picture, np.float64) * exposure
    _, e = np.frexp(p.max(-1))
    m = np.floor(np.ldexp(p, 8 - e[..., None])).clip(0, 255).astype(np.uint8)
    rgbe = np.concatenate([m, (e + 128)[..., None].astype(np.uint8)], -1)
    rgbe[p.max(-1) == 0] = 0
    with open(name, "wb") as f:
        f.write(b"#?RADIANCE\nEXPOSURE=%g\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (exposure, H, W))
        f.write(rgbe.tobytes())


def read_hdr(name, exposure):
    b = open(name, "rb").read()
    q = np.frombuffer(b[-W * H * 4:], np.uint8).reshape(H, W, 4)
    p = np.ldexp(q[..., :3] + 0.5, q[..., 3:].astype(int) - 136) / exposure
    return np.where(q[..., 3:] > 0, p, 0)


def smooth(r, edge):
    r = r @ [0.265, 0.670, 0.065]
    p = np.pad(r, 1, mode="edge")
    s = np.stack([p[j:j + H, i:i + W] for j in range(3) for i in range(3)])
    hi, lo = s.max(0), s.min(0)
    return ((hi - lo) < edge * np.maximum(hi, 0.01 * r.mean())) & (hi < 10 * r.mean())


def measures(r, i, m):
    floor = 0.01 * r.mean()
    r, i = r[m], i[m]
    d = i - r
    rel = np.abs(d) / np.maximum(r, floor)
    rmse = np.sqrt((d * d).mean())
    p = np.percentile(rel, [50, 90, 99, 100])
    return [m.sum(), i.mean() / r.mean(), *(i.mean(0) / r.mean(0)), rmse, rmse / r.mean(), *p]


def main():
    g = np.random.default_rng(7)
    y, x = np.mgrid[0:H, 0:W]
    r = np.stack([1 + x / W, 0.5 + y / H, np.full((H, W), 0.3)], -1) * np.where(x < 13, 0.2, 1.0)[..., None]
    r[3:6, 30:34] = 40.0  # a visible lamp
    r[20:23, 2:6] = 0.0  # nothing at all
    i = r * g.normal(1.01, 0.05, r.shape)
    i[21, 3] = [0.001, 0, 0.5]
    write_exr("reference.exr", r.astype(np.float32))
    write_exr("image.exr", i.astype(np.float32))
    write_hdr("image.hdr", i, 0.25)
    r = read_exr("reference.exr")
    for name, i in [("image.exr", read_exr("image.exr")), ("image.hdr", read_hdr("image.hdr", 0.25))]:
        for kind, m in [("all", np.ones((H, W), bool)), ("smooth", smooth(r, 0.15))]:
            print('    ("%s", "%s", [%s]),' % (name, kind, ", ".join("%.9e" % v for v in measures(r, i, m))))


main()
