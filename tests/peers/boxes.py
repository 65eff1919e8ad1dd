"""Direct light in two Cornell boxes, on smooth pixels.

boxes.py                          the built-in one, against Mitsuba's kept reference
boxes.py CORNELL.rad VIEW.vf      the walls of another, without its spheres, against Radiance"""
import os
import sys
import tempfile

import kiloray

REFERENCE = os.path.join(kiloray.ROOT, 'tests/peers/reference/cornell-direct.exr')
SIZE = 128


def holds(what, reference, picture, rmse_max, mean_max):
    rmse, mean = kiloray.difference(reference, picture)
    ok = rmse <= rmse_max and abs(mean) <= mean_max
    print('%s: relative RMSE %.3f %%, mean %+.3f %%: %s' % (what, 100 * rmse, 100 * mean, 'ok' if ok else 'FAILED'))
    return ok


def without_spheres(scene):
    """The other primitives of a file of Radiance, one a line."""
    with open(scene, encoding='utf-8') as file:
        tokens = [token for line in file for token in line.split('#')[0].split()]
    i = 0
    while i < len(tokens):
        begin, kind = i, tokens[i + 1]
        i += 3
        for _ in range(3):
            i += 1 + int(tokens[i])
        if kind != 'sphere':
            yield ' '.join(tokens[begin:i]) + '\n'


def built_in(folder):
    picture = os.path.join(folder, 'kiloray.exr')
    kiloray.render('cornell', picture, width=SIZE, height=SIZE, samples=256, shadow_samples=4)
    return holds('Cornell box, direct light, against Mitsuba', REFERENCE, picture, 0.005, 0.001)


def walls(folder, scene, view):
    import radiance
    rad, octree, theirs, ours = (os.path.join(folder, name) for name in ('walls.rad', 'walls.oct', 'radiance.hdr', 'kiloray.exr'))
    with open(rad, 'w', encoding='utf-8') as file:
        file.writelines(without_spheres(scene))
    radiance.octree(rad, octree)
    radiance.picture(octree, view, SIZE, theirs)
    kiloray.render(rad, ours, view=view, width=SIZE, height=SIZE, samples=64)
    # Beside the mean nothing is held: rpict's noise is of one ray a pixel.
    return holds('walls, direct light, against rpict', theirs, ours, 1, 0.005)


with tempfile.TemporaryDirectory() as folder:
    ok = walls(folder, *sys.argv[1:]) if sys.argv[1:] else built_in(folder)
sys.exit(not ok)
