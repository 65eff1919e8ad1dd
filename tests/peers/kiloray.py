"""Kiloray's commands: what renders, what compares pictures, and what writes scenes for its peers."""
import json
import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
found = subprocess.run(['bash', os.path.join(ROOT, 'tests/command')], stdout=subprocess.PIPE, text=True, check=True)
COMMAND = os.path.abspath(found.stdout.strip())


def rendering(scene, out, **options):
    """The command that renders a scene; options are those of `render`, and None leaves one out."""
    return [COMMAND, 'render', scene, *words(options), '--quiet', '-o', out]


def words(options):
    given = [('--' + name.replace('_', '-'), str(value)) for name, value in options.items() if value is not None]
    return [part for option in given for part in option]


def compile(files, out):
    subprocess.run([COMMAND, 'compile', *files, '--quiet', '-o', out], stdout=subprocess.DEVNULL, check=True)


def seconds(compiled, width, height, pixels, **options):
    """CPU seconds of a rendering on one thread, after a first one in the same process; writes its pixels."""
    command = [os.path.join(ROOT, 'target/release/render_time'), compiled, str(width), str(height), *words(options), '--out', pixels]
    return float(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)


def render(scene, out, **options):
    subprocess.run(rendering(scene, out, **options), check=True)


def difference(reference, picture):
    """Relative RMSE of the smooth pixels, and by what part their mean is greater than the reference's."""
    measures = picture + '.json'
    subprocess.run([COMMAND, 'compare', reference, picture, '--json', measures], stdout=subprocess.DEVNULL, check=True)
    with open(measures, encoding='utf-8') as file:
        smooth = json.load(file)['measures']['smooth']
    return smooth['relative_rmse'], smooth['mean_ratio'] - 1


def export(scene, folder):
    """Writes a built-in scene for all renderers; says what it has."""
    made = subprocess.run([os.path.join(ROOT, 'target/release/export'), scene, folder], stdout=subprocess.PIPE, check=True)
    return json.loads(made.stdout)
