#!/usr/bin/env python3
"""Time against error: Kiloray, Mitsuba and Radiance on the same scenes and the same light.

usage: curve.py [--scenes cornell,glass,conference] [--out target/peers] [--scale N] [--quick] [--only ..] [--again]

Run it by `tests/peers/curve`, which installs and builds what it needs. Writes `curve.csv`, `curve.svg` and
`curve.md` into the output folder.

The light is direct light, seen also by way of mirrors and clear dielectrics. Scenes are reduced to what all
three mean alike (`export` says what that changes) and given to each in its own format; the error is the
relative RMSE over smooth pixels against Mitsuba at very many samples, in f32 without any tone curve.

Time is that of the rendering alone, without start, reading, compiling the scene and writing a file: CPU seconds,
user and system, of all threads. For Mitsuba, whose start is Python's and whose kernels are compiled at run time, and for
Kiloray it is taken inside the process after a first run; for Radiance the same command on a picture of 2 x 2 pixels is
subtracted. What takes less than two seconds is run three times, what takes less than 20 ms nine times, and the shortest
counts. `total_s` is the CPU time of the whole process, of Kiloray's command for the same picture.
"""
import argparse
import csv
import os
import resource
import subprocess

import numpy as np

import images
import kiloray
import mitsuba_worker
import radiance

SIZES = {'cornell': (128, 128), 'glass': (192, 128), 'conference': (160, 100)}
REFERENCE_SPP = {'cornell': 1 << 16, 'glass': 1 << 15, 'conference': 1 << 15}

# Camera paths per pixel, shadow rays per light (0: as many as Kiloray likes): what is worth its time at each error.
KILORAY = [(1, 1), (2, 1), (4, 1), (16, 1), (64, 1), (256, 1), (1, 0), (2, 0), (4, 0), (8, 0), (16, 0), (1, 2),
           (2, 2), (1, 4), (2, 4), (4, 4), (8, 4), (16, 4), (64, 4), (1, 8), (2, 8), (1, 16), (2, 16), (4, 16), (8, 16),
           (16, 16), (1, 32), (2, 32), (1, 64), (2, 64), (4, 64), (1, 128), (2, 128), (1, 256), (16, 32), (16, 64)]
# The same and lights per point, where there are many.
MANY = [(1, 1, 1), (1, 1, 2), (1, 1, 4), (1, 1, 8), (2, 1, 4)]
# Paths, shadow rays, pixels along a square of which only corners are traced, contrast: fewer paths than pixels.
FEWER = [(1, 1, 2, 1), (1, 1, 4, 2), (1, 1, 4, 4), (1, 1, 4, 16), (1, 1, 8, 4), (1, 1, 16, 8), (1, 2, 2, 1), (1, 2, 4, 0.5),
         (1, 2, 4, 1), (1, 2, 4, 4), (1, 2, 8, 1), (1, 3, 2, 4), (1, 4, 2, 0.5), (1, 4, 2, 4), (1, 4, 4, 0.3), (1, 4, 4, 0.5),
         (1, 4, 4, 2), (1, 4, 4, 4), (1, 6, 2, 8), (1, 8, 2, 0.3), (1, 8, 4, 0.2), (1, 12, 2, 8), (1, 16, 2, 0.3), (1, 16, 4, 0.1),
         (1, 0, 2, 0.1), (1, 0, 4, 0.1)]
MITSUBA = [1, 4, 16, 64, 256, 1024, 4096]
RADIANCE = [(1, 0.2), (1, 0.05), (4, 0.2), (4, 0.1), (16, 0.2), (16, 0.1), (64, 0.2)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('--scenes', default='cornell,glass,conference')
    parser.add_argument('--out', default='target/peers')
    parser.add_argument('--only', default='kiloray,mitsuba,radiance', help="'none' makes the references")
    parser.add_argument('--scale', type=int, default=1, help='pictures so many times as wide and high')
    parser.add_argument('--quick', action='store_true', help='few points, a coarse reference')
    parser.add_argument('--again', action='store_true', help='only table and plot, from the last curve.csv')
    a = parser.parse_args()
    if a.again:
        with open(os.path.join(a.out, 'curve.csv'), newline='') as f:
            numbers = {'render_s', 'total_s', 'rel_rmse', 'mean_ratio', 'rel_rmse_everywhere'}
            rows = [{k: float(v) if k in numbers else v for k, v in row.items()} for row in csv.DictReader(f)]
        write(rows, a.out)
        return
    os.makedirs(a.out, exist_ok=True)
    rows = []
    for scene in a.scenes.split(','):
        rows += Scene(scene, a).measure()
    if rows:
        write(rows, a.out)


class Scene:
    def __init__(self, name, options):
        self.name, self.quick = name, options.quick
        self.only = options.only.split(',')
        self.dir = os.path.join(os.path.abspath(options.out), name)
        self.width, self.height = (side * options.scale for side in SIZES.get(name, (128, 128)))
        self.facts = kiloray.export(name, self.dir)
        print(name, self.facts, flush=True)

    def path(self, name):
        return os.path.join(self.dir, name)

    def measure(self):
        self.reference()
        rows = []
        if 'radiance' in self.only:
            self.agree()
        self.rows = rows
        if 'kiloray' in self.only:
            self.kiloray()
        if 'mitsuba' in self.only:
            for variant in ('llvm_ad_rgb', 'scalar_rgb'):
                self.mitsuba(variant)
        if 'radiance' in self.only:
            self.radiance()
        return rows

    def add(self, renderer, setting, render_s, total_s, image):
        rel, mean = images.error(self.image, image, self.mask)
        everywhere = images.error(self.image, image, np.ones_like(self.mask))[0]
        row = dict(scene=self.name, renderer=renderer, setting=setting, render_s=round(render_s, 5),
                   total_s=round(total_s, 4), rel_rmse=round(rel, 6), mean_ratio=round(mean, 5), rel_rmse_everywhere=round(everywhere, 6))
        self.rows.append(row)
        print('%-10s %-22s %-28s render %9.5f s  total %8.3f s  error %.5f  mean %.4f'
              % (self.name, renderer, setting, row['render_s'], total_s, rel, mean), flush=True)

    # The reference, and where renderers agree.

    def reference(self):
        spp = 1 << 12 if self.quick else REFERENCE_SPP.get(self.name, 1 << 16)
        path = self.path('reference-%d-%d.npy' % (self.width, spp))
        if not os.path.exists(path):
            self.worker('llvm_ad_rgb', 'reference', spp, path)
        self.image = images.load(path)
        self.mask = images.smooth(self.image)

    def agree(self):
        """Leaves out the pixels where Radiance means another light (it lets some through dielectrics)."""
        if not self.facts['specular']:
            return
        path = self.path('radiance-best-%d.npy' % self.width)
        if not os.path.exists(path):
            np.save(path, self.rtrace(64, 0.1, radiance.EXACT, self.width, self.height)[0])
        best = images.load(path)
        scale = np.maximum(self.image, 0.05 * self.image.mean())
        alike = (np.abs(best - self.image) < 0.1 * scale).all(2)
        left_out = float((self.mask & ~alike).sum() / max(self.mask.sum(), 1))
        self.mask &= alike
        print('%s: %.1f %% of the smooth pixels left out: Radiance means another light there' % (self.name, 100 * left_out))

    # The renderers.

    def kiloray(self):
        compiled, out, pixels = self.path('scene.kilo'), self.path('kiloray.exr'), self.path('kiloray.raw')
        kiloray.compile([self.path('scene.rad'), self.path('scene.vf')], compiled)
        many = MANY if self.facts['lights'] > 8 else []
        settings = [(*setting, None) for setting in KILORAY] + many
        settings = [(*setting, None, None) for setting in settings]
        for samples, shadow, spacing, contrast in FEWER:
            for lights in (None, 1, 4) if many else (None,):
                settings.append((samples, shadow, lights, spacing, contrast))
        for samples, shadow, lights, spacing, contrast in settings:
            if self.quick and samples * shadow > 64 or samples * shadow > 256 and self.name != 'cornell':
                continue
            chosen = dict(samples=samples, shadow_samples=shadow or None, lights_per_point=lights,
                          pixel_spacing=spacing, pixel_contrast=contrast)
            total_s = cpu(kiloray.rendering(self.path('scene.rad'), out, view=self.path('scene.vf'), width=self.width,
                                            height=self.height, threads=1, **chosen))[0]
            render_s = shortest(lambda: (kiloray.seconds(compiled, self.width, self.height, pixels, **chosen),))[0]
            image = images.load(out)
            if (np.fromfile(pixels, np.float32).reshape(image.shape) != image).any():
                raise SystemExit('render_time and the command have other pixels')
            setting = '%d paths, %s shadow' % (samples, shadow or 'adaptive') + (', %d lights' % lights if lights else '')
            setting += ', squares of %d, contrast %g' % (spacing, contrast) if spacing else ''
            self.add('kiloray', setting, render_s, total_s, image)

    def mitsuba(self, variant):
        if variant == 'scalar_rgb' and self.facts['specular']:
            print('%s: no scalar_rgb: an integrator of this light would have to run in Python' % self.name)
            return
        most = 64 if self.quick else 1024 if variant == 'scalar_rgb' else 4096
        for sampler in ('independent', 'multijitter'):
            for spp in [s for s in MITSUBA if s <= (most if sampler == 'independent' else 1024)]:
                path = self.path('mitsuba.npy')

                def run():
                    begin = children()
                    return self.worker(variant, sampler, spp, path), children() - begin
                render_s, used = shortest(run)
                self.add('mitsuba %s, %s' % (variant, sampler), '%d spp' % spp, render_s, used, images.load(path))

    def worker(self, variant, what, spp, path):
        return mitsuba_worker.render(self.path('scene.xml'), variant, what, spp, self.width, self.height, self.facts['specular'], path)

    def radiance(self):
        start = min(self.rtrace(1, 0.2, radiance.EXACT, 2, 2)[1] for _ in range(3))
        for name, settings in (('exact', radiance.EXACT), ('selective', radiance.QUICK)):
            if name == 'selective' and self.facts['lights'] < 2:
                continue
            for spp, ds in RADIANCE:
                # With many lights the costly settings take minutes, and reach no less error than Radiance's own bias.
                if self.quick and spp > 4 or self.facts['lights'] > 8 and spp > 0.8 / ds:
                    continue
                used, image = shortest(lambda: self.rtrace(spp, ds, settings, self.width, self.height)[::-1])
                # A difference, of what the system counts in milliseconds.
                self.add('radiance', '%d paths, -ds %g, %s' % (spp, ds, name), max(used - start, 1e-3), used, image)

    def rtrace(self, spp, ds, settings, width, height):
        octree = self.path('scene.oct')
        if not os.path.exists(octree):
            radiance.octree(self.path('scene.rad'), octree)
        rays = radiance.rays(self.path('scene.vf'), width, height, spp)
        used, out = cpu(radiance.rtrace(octree, settings, ds), stdin=rays, env=radiance.ENVIRONMENT)
        values = np.frombuffer(out, np.float32).reshape(height, width, spp, 3)
        return values.astype(np.float64).mean(2), used


def shortest(run):
    """The result of the shortest of several runs, whose time comes first; what takes long is run once."""
    runs = [run()]
    times = 1 if runs[0][0] >= 2 else 3 if runs[0][0] >= 0.02 else 9
    runs += [run() for _ in range(1, times)]
    return min(runs, key=lambda result: result[0])


def children():
    u = resource.getrusage(resource.RUSAGE_CHILDREN)
    return u.ru_utime + u.ru_stime


def cpu(command, stdin=None, env=None):
    begin = children()
    done = subprocess.run(command, input=stdin, stdout=subprocess.PIPE, env=env, check=True)
    return children() - begin, done.stdout


# What came out.

def front(rows):
    """The rows that no other beats in both time and error, by falling error."""
    best, out = float('inf'), []
    for row in sorted(rows, key=lambda r: (r['render_s'], r['rel_rmse'])):
        if row['rel_rmse'] < best:
            best = row['rel_rmse']
            out.append(row)
    return out


def time_at(rows, error):
    """Time that a front needs for an error, between its points by powers; None beyond its last."""
    points = [(r['rel_rmse'], r['render_s']) for r in front(rows)]
    for (e0, t0), (e1, t1) in zip(points, points[1:]):
        if e0 >= error >= e1:
            part = np.log(error / e0) / np.log(e1 / e0)
            return float(t0 * (t1 / t0) ** part)
    if points and error >= points[0][0]:
        return points[0][1]
    return None


def write(rows, out):
    with open(os.path.join(out, 'curve.csv'), 'w', newline='') as f:
        writer = csv.DictWriter(f, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    scenes = list(dict.fromkeys(r['scene'] for r in rows))
    lines = ['| scene | peer | error | its time, s | Kiloray, s | times faster |', '| --- | --- | --- | --- | --- | --- |']
    for scene in scenes:
        ours = [r for r in rows if r['scene'] == scene and r['renderer'] == 'kiloray']
        for peer in dict.fromkeys(r['renderer'] for r in rows if r['scene'] == scene and r['renderer'] != 'kiloray'):
            for point in front([r for r in rows if r['scene'] == scene and r['renderer'] == peer]):
                t = time_at(ours, point['rel_rmse'])
                factor = 'not reached' if t is None else '%.2f' % (point['render_s'] / t)
                lines.append('| %s | %s | %.5f | %.4f | %s | %s |' % (
                    scene, peer, point['rel_rmse'], point['render_s'], '-' if t is None else '%.4f' % t, factor))
    text = '\n'.join(lines) + '\n'
    with open(os.path.join(out, 'curve.md'), 'w') as f:
        f.write(text)
    print('\n' + text)
    plot(rows, scenes, out)


def plot(rows, scenes, out):
    import matplotlib
    matplotlib.use('svg')
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(1, len(scenes), figsize=(5 * len(scenes), 4.2), squeeze=False)
    for axis, scene in zip(axes[0], scenes):
        for renderer in dict.fromkeys(r['renderer'] for r in rows):
            points = front([r for r in rows if r['scene'] == scene and r['renderer'] == renderer])
            if points:
                axis.loglog([p['render_s'] for p in points], [p['rel_rmse'] for p in points], 'o-', label=renderer)
        axis.set_title(scene)
        axis.set_xlabel('time of rendering [s]')
        axis.grid(True, which='both', alpha=0.3)
    axes[0][0].set_ylabel('relative RMSE on smooth pixels')
    axes[0][0].legend()
    figure.tight_layout()
    figure.savefig(os.path.join(out, 'curve.svg'))


if __name__ == '__main__':
    main()
