"""Radiance as `setup` installs it: its calls, and direct light as it is to render it."""
import os
import subprocess

import pyradiance

ROOT = os.path.dirname(pyradiance.__file__)
ENVIRONMENT = dict(os.environ, PATH=os.path.join(ROOT, 'bin') + ':' + os.environ['PATH'], RAYPATH=os.path.join(ROOT, 'lib'))

# No light between surfaces, nor by way of mirrors to others; what highlights reflect is sampled, however weak; lamps are sampled all over.
DIRECT = '-w -ab 0 -dj .9 -dr 0 -st 0 -ss 16 -lr 12'.split()
# Every lamp is asked by every point.
EXACT = [*DIRECT, *'-dt 0 -dc 1 -lw 1e-5'.split()]
# As a user would who is in a hurry: weak lamps are guessed.
QUICK = [*DIRECT, *'-dt .05 -dc .5 -lw 1e-3'.split()]


def octree(scene, out):
    with open(out, 'wb') as file:
        subprocess.run(['oconv', scene], stdout=file, env=ENVIRONMENT, check=True)


def picture(octree, view, size, out):
    """A square picture by `rpict`, lamps in small parts, and a ray a pixel anywhere in it."""
    command = ['rpict', *EXACT, '-ds', '.02', '-ps', '1', '-pj', '.9', '-vf', view, '-x', str(size), '-y', str(size), octree]
    with open(out, 'wb') as file:
        subprocess.run(command, stdout=file, env=ENVIRONMENT, check=True)


def rays(view, width, height, paths):
    """So many a pixel, for `rtrace`."""
    command = ['vwrays', '-ff', '-vf', view, '-x', str(width), '-y', str(height), '-pa', '0', '-c', str(paths), '-pj', '1']
    return subprocess.run(command, stdout=subprocess.PIPE, env=ENVIRONMENT, check=True).stdout


def rtrace(octree, settings, ds):
    """The command that makes radiance, three f32, of each ray."""
    return ['rtrace', *settings, '-h', '-fff', '-ov', '-ds', str(ds), octree]
