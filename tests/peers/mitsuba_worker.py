"""One Mitsuba rendering in a process of its own, as a process has one variant of it; its CPU seconds."""
import glob
import json
import os
import subprocess
import sys
import time

import numpy as np


def render(scene, variant, what, spp, width, height, specular, out):
    """Renders SCENE.xml to OUT.npy by a sampler, or as a reference; says the CPU seconds of the rendering alone."""
    done = subprocess.run([sys.executable, os.path.abspath(__file__), json.dumps(locals())], check=True, stdout=subprocess.PIPE)
    return float(done.stdout)


def find_llvm():
    if 'DRJIT_LIBLLVM_PATH' in os.environ:
        return
    found = sorted(glob.glob('/usr/lib/x86_64-linux-gnu/libLLVM*.so*'),
                   key=lambda p: max([int(n) for n in ''.join(c if c.isdigit() else ' ' for c in p).split() if 15 < int(n) < 64] or [0]))
    if found:
        os.environ['DRJIT_LIBLLVM_PATH'] = found[-1]


def work(scene, variant, what, spp, width, height, specular, out):
    find_llvm()
    import mitsuba as mi
    mi.set_variant(variant)
    # These need a variant.
    import drjit as dr
    import transport

    dr.set_thread_count(2)  # With one thread rendering hangs (3.9); CPU seconds are those of both.
    scene = mi.load_file(scene, width=width, height=height, sampler='multijitter' if what == 'reference' else what)
    integrator = transport.direct(specular)

    def passes(step):
        """The mean of as many passes of `step` samples a pixel as make all."""
        count = spp // step
        return sum(once(step, 1 + i) for i in range(count)) / count

    def once(samples, seed):
        return np.array(mi.render(scene, integrator=integrator, spp=samples, seed=seed), dtype=np.float64)

    if what == 'reference':
        image, used = passes(min(spp, 1 << 10)), 0.0
    else:
        # Independent samples in passes of at most 256: larger ones leave the cache and are slower. Stratified
        # ones must be made in one.
        step = min(spp, 256) if what == 'independent' and variant != 'scalar_rgb' else spp
        once(1 if variant == 'scalar_rgb' else step, 1000)
        begin = time.process_time()
        image = passes(step)
        used = time.process_time() - begin
    np.save(out, image.astype(np.float32))
    print(used)


if __name__ == '__main__':
    work(**json.loads(sys.argv[1]))
