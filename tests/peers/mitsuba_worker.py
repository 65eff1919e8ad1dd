#!/usr/bin/env python3
"""One Mitsuba rendering in a process of its own, for `curve.py`; prints its CPU seconds.

usage: mitsuba_worker.py SCENE.xml VARIANT reference|independent|multijitter SPP WIDTH HEIGHT SPECULAR OUT.npy
"""
import glob
import os
import sys
import time

import numpy as np

if 'DRJIT_LIBLLVM_PATH' not in os.environ:
    found = sorted(glob.glob('/usr/lib/x86_64-linux-gnu/libLLVM*.so*'),
                   key=lambda p: max([int(n) for n in ''.join(c if c.isdigit() else ' ' for c in p).split() if 15 < int(n) < 64] or [0]))
    if found:
        os.environ['DRJIT_LIBLLVM_PATH'] = found[-1]
import mitsuba as mi

path, variant, what, spp, width, height, specular, out = sys.argv[1:]
spp = int(spp)
mi.set_variant(variant)
import drjit as dr

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import transport

dr.set_thread_count(2)  # With one thread rendering hangs (3.9); CPU seconds are those of both.
scene = mi.load_file(path, width=int(width), height=int(height),
                     sampler='multijitter' if what == 'reference' else what)
integrator = transport.direct(specular == '1')


def render(seed, samples):
    return np.array(mi.render(scene, integrator=integrator, spp=samples, seed=seed), dtype=np.float64)


if what == 'reference':
    step = min(spp, 1 << 10)
    image = sum(render(seed + 1, step) for seed in range(spp // step)) / (spp // step)
    used = 0.0
else:
    # Independent samples in passes of at most 256: larger ones leave the cache and are slower. Stratified
    # ones must be made in one.
    step = min(spp, 256) if what == 'independent' and variant != 'scalar_rgb' else spp
    render(1000, 1 if variant == 'scalar_rgb' else step)
    begin = time.process_time()
    image = sum(render(seed + 1, step) for seed in range(spp // step)) / (spp // step)
    used = time.process_time() - begin
np.save(out, image.astype(np.float32))
print(used)
