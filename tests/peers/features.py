"""One feature of Radiance's files after the other, in a room with a floor, a wall and a lamp, against rpict: the mean of smooth pixels, to 0.3 %."""
import os
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import kiloray
import radiance

FLOOR = 'void plastic fl 0 0 5 .5 .5 .5 {}\nfl polygon f 0 0 12 -3 -3 0 3 -3 0 3 3 0 -3 3 0\n'
WALL = 'void plastic wl 0 0 5 .6 .3 .2 0 0\nwl polygon w 0 0 12 -3 2 0 3 2 0 3 2 3 -3 2 3\n'
ROOM = FLOOR.format('0 0') + WALL
PANEL = 'polygon p 0 0 12 -.3 -.3 2.4 -.3 .3 2.4 .3 .3 2.4 .3 -.3 2.4\n'
LIGHT = 'void light l 0 0 3 40 40 40\n'
LIT = ROOM + LIGHT + 'l ' + PANEL
PANE = 'm polygon q 0 0 12 -.8 0 .1 .8 0 .1 .8 .3 1.3 -.8 .3 1.3\n'
BACK = 'm polygon q 0 0 12 -.8 .3 1.3 .8 .3 1.3 .8 0 .1 -.8 0 .1\n'
BALL = 'm sphere b 0 0 4 0 .3 .6 .5\n'
MATT = 'void plastic m 0 0 5 .2 .4 .6 0 0\n'
VIEW = '-vtv -vp 0 -4 1.6 -vd 0 4 -1.1 -vu 0 0 1 -vh 45 -vv 45 -vo 0 -va 0 -vs 0 -vl 0'

SCENES = {
    'lamp: polygon': LIT,
    'lamp: ring': ROOM + LIGHT + 'l ring r 0 0 8 0 0 2.2 0 0 -1 0 .3\n',
    'lamp: sun': ROOM + 'void light l 0 0 3 4e4 4e4 4e4\nl source s 0 0 4 .3 -.5 1 .533\n',
    'lamp: illum': ROOM + 'void illum l 0 0 3 40 40 40\nl ' + PANEL,
    'lamp: illum with an alternate': ROOM + 'void glass g 0 0 3 .5 .5 .5\nvoid illum l 1 g 0 3 40 40 40\nl ' + PANEL,
    'lamp: illum over a rough floor': FLOOR.format('.06 .1') + WALL + 'void illum l 0 0 3 40 40 40\nl ' + PANEL,
    'lamp: over a rough floor': FLOOR.format('.06 .1') + WALL + LIGHT + 'l ' + PANEL,
    'lamp: over a smooth floor': FLOOR.format('.06 0') + WALL + LIGHT + 'l ' + PANEL,
    'lamp: spotlight': ROOM + 'void spotlight l 0 0 7 400 400 400 50 0 0 -1\nl ring r 0 0 8 0 0 2.2 0 0 -1 0 .1\n',
    'lamp: long spotlight': ROOM + 'void spotlight l 0 0 7 400 400 400 70 .4 .6 -2\nl polygon p 0 0 12 -.1 -.1 2.2 -.1 .1 2.2 .1 .1 2.2 .1 -.1 2.2\n',
    'glow, seen': LIT + 'void glow m 0 0 4 3 2 1 0\n' + BALL,
    'metal: smooth ball': LIT + 'void metal m 0 0 5 .7 .6 .3 .9 0\n' + BALL,
    'mirror with an alternate': LIT + 'void plastic x 0 0 5 .5 .1 .1 0 0\nvoid mirror m 1 x 0 3 .8 .8 .8\n' + BALL,
    'glass: index': LIT + 'void glass m 0 0 4 .9 .8 .7 1.8\n' + PANE,
    'glass: before a lamp': ROOM + 'void light l 0 0 3 9 9 9\nl ring r 0 0 8 .1 1 .8 0 -1 0 0 .3\nvoid glass m 0 0 3 .6 .7 .8\n' + PANE,
    'plastic: from behind': LIT + 'void plastic m 0 0 5 .2 .4 .6 .05 .1\n' + BACK,
    'plastic: bubble': LIT + 'void plastic m 0 0 5 .2 .4 .6 .05 .1\n' + BALL.replace('sphere', 'bubble'),
    'trans: from behind': LIT + 'void trans m 0 0 7 .5 .6 .7 .02 .1 .5 .3\n' + BACK,
    'cone': LIT + MATT + 'm cone c 0 0 8 0 .3 0 0 .3 1 .6 .1\n',
    'cup': LIT + MATT + 'm cup c 0 0 8 0 .3 0 0 .3 1 .1 .6\n',
    'cylinder': LIT + MATT + 'm cylinder c 0 0 7 0 .3 0 0 .3 1 .4\n',
    'tube': LIT + MATT + 'm tube c 0 0 7 0 .3 0 0 .3 1 .4\n',
    'ring': LIT + MATT + 'm ring c 0 0 8 0 .3 .6 0 -1 .4 .2 .6\n',
    'polygon: concave': LIT + MATT + 'm polygon q 0 0 21 -.8 0 .1 .8 0 .1 .8 .3 1.3 0 .1 .5 -.8 .3 1.3 -.8 .2 .9 -.8 .1 .5\n',
    'polygon: with a hole': LIT + MATT + 'm polygon q 0 0 30 -.8 0 .1 .8 0 .1 .8 0 1.3 -.8 0 1.3 -.8 0 .1 -.3 0 .4 -.3 0 .9 .3 0 .9 .3 0 .4 -.3 0 .4\n',
}
for name, material in {
    'plastic: smooth': 'plastic m 0 0 5 .2 .4 .6 .05 0',
    'plastic: rough': 'plastic m 0 0 5 .2 .4 .6 .08 .2',
    'metal: rough': 'metal m 0 0 5 .7 .6 .3 .9 .1',
    'mirror': 'mirror m 0 0 3 .8 .8 .8',
    'glass': 'glass m 0 0 3 .9 .8 .7',
    'trans: diffuse': 'trans m 0 0 7 .5 .6 .7 0 0 .5 0',
    'trans: clear': 'trans m 0 0 7 .5 .6 .7 .04 0 .5 .6',
    'trans: rough': 'trans m 0 0 7 .5 .6 .7 .04 .1 .5 .6',
}.items():
    SCENES[name + ' ball'] = LIT + 'void ' + material + '\n' + BALL
    SCENES[name + ' pane'] = LIT + 'void ' + material + '\n' + PANE
# As a pane alone: what is in its shadow differs (formats.md).
SCENES['metal: smooth pane'] = LIT + 'void metal m 0 0 5 .7 .6 .3 .9 0\n' + PANE
SCENES['dielectric pane'] = LIT + 'void dielectric m 0 0 5 .9 .8 .7 1.5 0\n' + PANE

VIEWS = {
    'view: parallel': VIEW.replace('-vtv', '-vtl').replace('-vh 45 -vv 45', '-vh 3 -vv 3'),
    'view: shifted': VIEW.replace('-vs 0 -vl 0', '-vs .2 -vl -.3'),
    'view: clipped': VIEW.replace('-vo 0 -va 0', '-vo 3.2 -va 5'),
}
SCENES.update({name: LIT + MATT + BALL for name in VIEWS})

FILES = ('scene.rad', 'view.vf', 'scene.oct', 'radiance.hdr', 'kiloray.exr')
WITHIN = 0.003
SIZE = 112


def difference(name):
    """By what part the mean of smooth pixels is greater than Radiance's."""
    with tempfile.TemporaryDirectory() as folder:
        scene, view, octree, exact, ours = (os.path.join(folder, file) for file in FILES)
        with open(scene, 'w', encoding='utf-8') as out:
            out.write(SCENES[name])
        with open(view, 'w', encoding='utf-8') as out:
            out.write('rvu ' + VIEWS.get(name, VIEW) + '\n')
        radiance.octree(scene, octree)
        radiance.picture(octree, view, SIZE, exact)
        kiloray.render(scene, ours, view=view, width=SIZE, height=SIZE, samples=16, threads=1)
        return kiloray.difference(exact, ours)[1]


def main():
    failed = 0
    with ThreadPoolExecutor(os.cpu_count()) as cores:
        for name, part in zip(SCENES, cores.map(difference, SCENES)):
            ok = abs(part) <= WITHIN
            failed += not ok
            print('%-32s %+.3f %%%s' % (name, 100 * part, '' if ok else '  FAILED'), flush=True)
    print('%d features, %d beyond %.1f %%' % (len(SCENES), failed, 100 * WITHIN))
    sys.exit(failed > 0)


main()
