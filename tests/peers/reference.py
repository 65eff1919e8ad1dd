#!/usr/bin/env python3
"""Makes the kept reference of the Cornell box in direct light: `reference/cornell-direct.exr`, f32, 128 x 128.

usage: $(tests/peers/setup) tests/peers/reference.py     after `cargo build --release -p kiloray-tests --bin export`

Mitsuba, its `direct` integrator (one sample of the lamp), box filter, 64 passes of 1024 stratified samples per
pixel with different seeds; the scene is what `export cornell` writes.
"""
import os
import tempfile

import numpy as np

import kiloray
import mitsuba_worker

here = os.path.dirname(os.path.abspath(__file__))

WIDTH, SPP = 128, 1 << 16

with tempfile.TemporaryDirectory() as folder:
    facts = kiloray.export('cornell', folder)
    out = os.path.join(folder, 'image.npy')
    mitsuba_worker.render(os.path.join(folder, 'scene.xml'), 'llvm_ad_rgb', 'reference', SPP, WIDTH, WIDTH, facts['specular'], out)
    image = np.load(out)

import mitsuba as mi  # noqa: E402

mi.set_variant('scalar_rgb')
os.makedirs(os.path.join(here, 'reference'), exist_ok=True)
mi.Bitmap(image).write(os.path.join(here, 'reference', 'cornell-direct.exr'))
print('mean', image.mean((0, 1)))
