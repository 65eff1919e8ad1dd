//! What the help says beyond a line for each option.

pub(super) const ABOUT: &str = "\
Ray tracing in kilobytes: a scene is compiled to small blocks, and rendered in as little memory as
you say. The picture does not depend on the memory, the threads or the machine.";

pub(super) const EXAMPLES: &str = "\
Examples:
  kiloray                                          render a built-in scene
  kiloray scenes                                   list the built-in scenes
  kiloray render glass -o glass.png                render one of them
  kiloray render room.rad lamps.rad --view room.vf -o room.exr
  kiloray render sinc:1000 --memory 64KiB          two million triangles in 64 KiB
  kiloray compare reference.exr room.exr -o difference.png

Exit codes: 0 done, 1 failed, 2 the command line makes no sense.
'kiloray COMMAND --help' tells more about a command. Of an option given twice the last one counts.";

pub(super) const RENDER: &str = "\
Examples:
  kiloray render cornell                           cornell.png, with the defaults
  kiloray render colour-cube:40 --width 800 --samples 64 -o cube.png
  kiloray render scene.obj lights.rad view.vf -o scene.exr
  kiloray render big.kilo --memory 256KiB --json run.json
  kiloray render cornell --exposure 1.5            a PNG brighter by one and a half stops

A PNG is for the eye: radiance is multiplied by 2^STOPS, the brightest parts are compressed by
Reinhard's curve, and the result is encoded as sRGB. 'auto' brings the logarithmic mean of the
luminance to middle grey, and prints the stops it chose. .hdr (RGBE) and .exr (32-bit float) hold
radiance as it is.

The image_hash of --json is the BLAKE3 hash of all linear pixels: rows from the top, red, green and
blue as 32-bit little-endian floats.";

pub(super) const COMPILE: &str = "\
Examples:
  kiloray compile room.rad lamps.rad -o room.kilo
  kiloray compile sphereflake:5 --block 4KiB -o flake.kilo
  kiloray compile cornell                          only look at what it needs";

pub(super) const PLAN: &str = "\
Examples:
  kiloray plan cornell --memory 64KiB
  kiloray plan room.kilo --memory 512KiB

Exit code 1 says that the memory is too small; the line that does not fit is named, with what is
needed.";

pub(super) const COMPARE: &str = "\
Examples:
  kiloray compare reference.exr image.exr
  kiloray compare reference.hdr image.hdr -o difference.png --mask floor.png

Measures, over all pixels and over smooth ones (away from edges and from what is ten times brighter
than the mean): the mean of the image over the mean of the reference, RMSE, RMSE over the
reference's mean, and percentiles of the relative error, |image - reference| over the reference but
at least 1 % of its mean. The picture shows the worst relative error of each pixel on a logarithmic
scale from 0.1 % (black) to 100 % (pale yellow).";

pub(super) const COMPLETIONS: &str = "\
Examples:
  kiloray completions bash > ~/.local/share/bash-completion/completions/kiloray
  kiloray completions zsh > ~/.zfunc/_kiloray
  kiloray completions fish > ~/.config/fish/completions/kiloray.fish";
