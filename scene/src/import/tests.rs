use std::fs;
use std::path::PathBuf;

use super::*;
use crate::model::Note;

/// A directory of files that goes with the test.
pub(super) struct Files(tempfile::TempDir);

impl Files {
    pub(super) fn new(files: &[(&str, &str)]) -> Self {
        let dir = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = dir.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        Self(dir)
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The file alone, without defaults.
    pub(super) fn load(&self, name: &str) -> Result<Model, ImportError> {
        load(&[self.path(name)], &ImportOptions { bare: true, ..ImportOptions::default() })
    }

    /// The error's one line, without the directory.
    pub(super) fn error(&self, name: &str) -> String {
        let line = self.load(name).expect_err(name).to_string();
        assert!(!line.contains('\n'), "{line}");
        line.replace(&format!("{}/", self.0.path().display()), "")
    }
}

pub(super) fn notes(model: &Model) -> Vec<(&str, u64)> {
    model.notes.iter().map(|Note { text, count, .. }| (text.as_str(), *count)).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
const BALL: &str = "void plastic m 0 0 5 .5 .5 .5 0 0\nm sphere s 0 0 4 0 0 0 1\n";

#[test]
fn several_files_make_one_scene() {
    let files = Files::new(&[("a.obj", SQUARE), ("b.rad", BALL), ("v.vf", "rvu -vp 0 -9 0\n")]);
    let paths = ["a.obj", "b.rad", "v.vf", "a.obj"].map(|name| files.path(name));
    let model = load(&paths, &ImportOptions::default()).unwrap();
    assert_eq!((model.triangles.len(), model.spheres.len()), (4, 1));
    assert_eq!((model.views.len(), model.views[0].name.as_str()), (1, "v"));
    let last = model.triangles[3].vertices.map(|i| model.vertices[i as usize]);
    assert!(last.iter().all(|p| p.max_element() <= 1.0), "indices count from their own file");
    assert_eq!(model.lights.len(), 2);
    let told: Vec<_> = notes(&model);
    assert!(told.iter().any(|(text, _)| text.starts_with("no light in the scene")), "{told:?}");
}

#[test]
fn an_error_brings_the_notes_that_came_before() {
    let files = Files::new(&[("a.rad", "void sphere s 0 0 4 0 0 0 1\n")]);
    let error = files.load("a.rad").unwrap_err();
    assert!(matches!(error.cause, Cause::Empty));
    let notes: Vec<_> = error.notes.iter().map(|note| (note.first.line, note.count)).collect();
    assert_eq!(notes, [(1, 1)]);
}

#[test]
fn a_scene_with_light_and_view_gets_no_default() {
    let sun = "void light l 0 0 3 1 1 1\nl source s 0 0 4 0 0 1 .5\n";
    let files = Files::new(&[("a.rad", &format!("{BALL}{sun}")), ("v.vf", "rvu -vp 0 -9 0\n")]);
    let paths = ["a.rad", "v.vf"].map(|name| files.path(name));
    let model = load(&paths, &ImportOptions::default()).unwrap();
    assert_eq!((model.lights.len(), model.views.len()), (1, 1));
    assert!(model.notes.is_empty());
}

#[test]
fn a_scene_that_only_glows_gets_no_default_light() {
    let glow = "void glow g 0 0 4 1 1 1 0\n";
    for (thing, light) in [
        ("g source s 0 0 4 0 0 1 180\n", 1),
        ("g sphere s 0 0 4 0 0 9 1\n", 0),
        ("g polygon s 0 0 9 0 0 9 1 0 9 0 1 9\n", 0),
        ("void light l 0 0 3 1 1 1\nl bubble s 0 0 4 0 0 0 9\n", 0),
    ] {
        let files = Files::new(&[("a.rad", &format!("{BALL}{glow}{thing}"))]);
        let model = load(&[files.path("a.rad")], &ImportOptions::default()).unwrap();
        assert_eq!(model.lights.len(), light, "{thing}");
        let told = notes(&model);
        let dark = |(text, _): &&(&str, u64)| text.starts_with("nothing in the scene lights");
        assert_eq!(told.iter().filter(dark).count(), 1, "{thing}: {told:?}");
        assert!(told.iter().filter(dark).all(|(text, _)| text.contains("`light` that shines out")));
    }
    // A glow that nothing has, and black ones, are no light.
    let unused = format!("{BALL}{glow}void light l 0 0 3 0 0 0\nl sphere s 0 0 4 0 0 9 1\n");
    let files = Files::new(&[("a.rad", &unused)]);
    let model = load(&[files.path("a.rad")], &ImportOptions::default()).unwrap();
    assert_eq!(model.lights.len(), 2);
}

#[test]
fn upwards_does_not_depend_on_the_case_of_an_extension() {
    for (name, text, up) in [
        ("a.obj", SQUARE, glam::DVec3::Y),
        ("A.OBJ", SQUARE, glam::DVec3::Y),
        ("A.RAD", BALL, glam::DVec3::Z),
    ] {
        let files = Files::new(&[(name, text)]);
        let model = load(&[files.path(name)], &ImportOptions::default()).unwrap();
        assert_eq!((model.views[0].up, model.lights[0].u), (up, up), "{name}");
    }
}

#[test]
fn the_default_view_holds_every_corner() {
    let thin = "v 5 0 0\nv 5 900 0\nv 5 0 .1\nf 1 2 3\n";
    for (name, text) in [("a.obj", SQUARE), ("a.obj", thin), ("a.rad", BALL)] {
        let files = Files::new(&[(name, text)]);
        let model = load(&[files.path(name)], &ImportOptions::default()).unwrap();
        let [view] = &model.views[..] else { panic!() };
        let right = view.direction.cross(view.up).normalize();
        let above = right.cross(view.direction);
        let tan = (view.size[0] / 2.0).to_radians().tan();
        let round = (0..8).map(|i| {
            let sign = |bit: i32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            glam::dvec3(sign(0), sign(1), sign(2))
        });
        let points = model.vertices.iter().copied().chain(round.filter(|_| name == "a.rad"));
        for p in points {
            let d = p - view.position;
            let depth = d.dot(view.direction);
            assert!(depth > 0.0);
            assert!(d.dot(right).abs().max(d.dot(above).abs()) <= tan * depth, "{p}");
        }
    }
}

/// What must fail, and with which words.
#[test]
fn bad_files_get_an_error_of_one_line() {
    let cases: &[(&str, &str, &str)] = &[
        ("nan.obj", "v 0 0 0\nv nan 1 0\nv 0 1 inf\nf 1 2 3\n", "nan.obj:2: `nan` is not a finite"),
        ("big.obj", "v 0 0 1e999\n", "big.obj:1: `1e999` is not a finite"),
        ("empty.obj", "", "empty.obj: nothing to render"),
        ("only.obj", "v 1 2 3\n# f\n", "only.obj: nothing to render"),
        ("idx.obj", "f 1 2 3\n", "idx.obj:1: there is no vertex 1: 0 are defined"),
        ("neg.obj", "v 0 0 0\nf -1 -2 -3\n", "neg.obj:2: there is no vertex -2"),
        ("zero.obj", "v 0 0 0\nf 0 1 1\n", "zero.obj:2: there is no vertex 0"),
        ("far.obj", "v 0 0 0\nf 1 99999999999999999999 1\n", "is not the index"),
        ("norm.obj", "v 0 0 0\nf 1//1 1//2 1//3\n", "there is no normal 1"),
        (
            "tex.obj",
            "v 0 0 0\nvt 0 0\nf 1/1 1/-1 1/7\n",
            "tex.obj:3: there is no texture coordinate 7: 1 are defined before",
        ),
        ("uv.obj", "v 0 0 0\nf 1/xyz 1 1\n", "`xyz` is not the index of a texture coordinate"),
        ("word.obj", "v 0 zero 0\n", "word.obj:1: `zero` is not a number"),
        ("few.obj", "v 0 0\n", "`v` needs three numbers"),
        ("two.obj", "v 0 0 0\nf 1 1\n", "at least three corners"),
        ("odd.obj", "hello world\n", "odd.obj:1: `hello` is not a statement"),
        ("call.obj", "v 0 0 0\ncall b.obj 1 2\n", "call.obj:2: `call` includes a file"),
        ("csh.obj", "csh -rm x\n", "csh.obj:1: `csh` runs a command, which is never done"),
        ("weight.obj", "v 1 0 0 0\n", "weight.obj:1: a weight of zero"),
        ("color.obj", "v 1 0 0 1 red 0\n", "color.obj:1: `red` is not a number"),
        ("use.obj", "v 1 0 0\nusemtl # none\n", "use.obj:2: usemtl without a name"),
        ("lib.obj", "mtllib\n", "lib.obj:1: mtllib without a name"),
        ("join.obj", "v 1 0 0\nf 1 \\\n2 \\\n3\n", "join.obj:4: there is no vertex 2"),
        ("empty.rad", "", "empty.rad: nothing to render"),
        ("comment.rad", "# nothing\n\n", "nothing to render"),
        ("short.rad", "void polygon a 0 0 9 0 0 0 1 0 0\n", "9 numbers announced, 6 found"),
        (
            "nomat.rad",
            "nomat polygon a 0 0 9 0 0 0 1 0 0 0 1 0\n",
            "nomat.rad:1: polygon `a`: the modifier `nomat` is not defined",
        ),
        ("cmd.rad", "!rm -rf /nonexistent-kiloray\n", "cmd.rad:1: the command `rm` is not run"),
        ("huge.rad", "void polygon a 0 0 99999999999999999999 0\n", "is not a count"),
        ("many.rad", "void polygon a 0 0 999999999 0\n", "too many numbers: the limit is"),
        (
            "self.rad",
            "!xform self.rad\n",
            "self.rad: the file includes itself (included at self.rad:1)",
        ),
        (
            "type.rad",
            "void plastik m 0 0 5 1 1 1 0 0\n",
            "type.rad:1: `plastik` is not a type of object",
        ),
        (
            "more.rad",
            "void plastic W\n0 0 5 1 1 1 0 0 99\nW sphere s 0 0 4 0 0 0 1\n",
            "more.rad:3: `W` is not a type of object; `W` of line 1, before it, may have more arguments than it announces",
        ),
        (
            "count.rad",
            "void plastic m\n0\n0\n4 1 1 1 0\n",
            "count.rad:4: plastic `m`: 4 numbers where it takes 5",
        ),
        ("nan.rad", "void plastic m 0 0 5 1 nan 1 0 0\n", "number 2 of 5: `nan` is not a finite"),
        (
            "neg.rad",
            "void plastic m 0 0 5 1 -1 1 0 0\nm sphere s 0 0 4 0 0 0 1\n",
            "neg.rad:1: plastic `m`: number 2 of 5 is -1, below zero",
        ),
        (
            "gone.rad",
            "\n!xform -t 1 2 3 gone/x.rad\n",
            "gone/x.rad: no such file (included at gone.rad:2)",
        ),
        ("stdin.rad", "!xform -t 1 2 3\n", "standard input"),
        ("shell.rad", "!genbox m b 1 1 1 > x\n", "`>` in a command"),
        ("sub.rad", "!xform `rm -rf x`\n", "in a command"),
        ("quote.rad", "!xform 'a\n", "quote"),
        ("scale.rad", "!xform -s 0 x.rad\n", "-s 0"),
        ("opt.rad", "!xform -q 0 x.rad\n", "`-q`"),
        ("array.rad", "!xform -a 0 x.rad\n", "array.rad:1: xform: `0` is not a count"),
        ("real.rad", "\n!xform -a 3.0 x.rad\n", "real.rad:2: xform: `3.0` is not a count: a whole"),
        ("times.rad", "!xform -i 2.5 -t 1 0 0 x.rad\n", "`2.5` is not a count"),
        ("last.rad", "!xform -a\n", "the option `-a` lacks a value"),
        ("args.rad", "!xform -f args x.rad\n", "args.rad:1: xform: -f takes options from a file"),
        ("wave.rad", "!genbox m b 1 1 1 -o\n", "genbox -o writes a Wavefront mesh"),
        ("turn.rad", "!genbox m b 1 1 1 -i -r .1\n", "-i with -r is not built in"),
        ("edge.rad", "!genbox m b 1 1 1 -b .6\n", "more than half of a side"),
        ("what.rad", "!genbox m b 1 1 1 -z\n", "the option `-z` is not known"),
        ("inst.rad", "void instance a 1 a.oct 0 0\n", "inst.rad:1: instance `a`: not read"),
        ("box.rad", "!genbox m b 1 1\n", "genbox takes"),
        ("flat.rad", "void plastic m 0 0 5 1 1 1 0 0\n!genbox m b 1 1 0\n", "not above zero"),
        ("mesh.rad", "void mesh a 1 a.rtm 0 0\n", "compiled mesh"),
        ("bad.vf", "hello\n", "no view options"),
        ("fish.vf", "rvu -vth -vp 0 0 0\n", "fish.vf:1: the view type `-vth`"),
        (
            "angle.vf",
            "# view\nrvu -vta\n",
            "angle.vf:2: the view type `-vta` is not built in; take -vtv",
        ),
        ("tube.vf", "rvu -vtc\n", "tube.vf:1: the view type `-vtc`"),
        ("plan.vf", "rvu -vts\n", "plan.vf:1: the view type `-vts`"),
        ("x.glb", "glTF", "not a kind of file"),
        ("x.mtl", "newmtl a\n", "name the .obj"),
        ("noext", "v 0 0 0\n", "not a kind of file"),
    ];
    for (name, text, says) in cases {
        let files = Files::new(&[(name, text)]);
        let line = files.error(name);
        assert!(line.contains(says), "{name}: {line}");
        assert!(line.contains(name), "{name}: {line}");
    }
    let none = Files::new(&[]);
    assert_eq!(none.error("missing.rad"), "missing.rad: no such file");
    assert_eq!(none.error("missing.xyz"), "missing.xyz: no such file");
}

/// DOS ends a text with a byte of its own.
#[test]
fn an_end_of_file_that_is_written_is_no_text() {
    let obj = format!("mtllib m.mtl\n{SQUARE}\x1a");
    let rad = format!("{BALL}\x1a");
    let names = [
        ("a.obj", &obj[..]),
        ("m.mtl", "newmtl a\n\x1a"),
        ("b.rad", &rad),
        ("v.vf", "rvu -vp 0 0 1\n\x1a"),
    ];
    let files = Files::new(&names);
    let paths = ["a.obj", "b.rad", "v.vf"].map(|name| files.path(name));
    let model = load(&paths, &ImportOptions { bare: true, ..ImportOptions::default() }).unwrap();
    assert_eq!((model.triangles.len(), model.spheres.len(), model.views.len()), (2, 1, 1));
    // Anywhere else it is a sign that nothing knows.
    let inside = Files::new(&[("a.rad", &format!("\x1a\n{BALL}"))]);
    assert!(inside.error("a.rad").starts_with("a.rad:2: "));
}

#[test]
fn binary_files_are_refused() {
    for name in ["a.rad", "a.obj", "a.vf"] {
        let files = Files::new(&[]);
        let noise: Vec<u8> =
            (0..100_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        fs::write(files.path(name), &noise).unwrap();
        assert_eq!(files.error(name), format!("{name}: a binary file where text is expected"));
    }
    let files = Files::new(&[("d.rad/x", ""), ("zero.rad", "!xform /dev/zero\n")]);
    assert!(files.error("d.rad").contains("not a regular file"));
    assert!(files.error("zero.rad").starts_with("/dev/zero: "));
    let odd = error::place(std::path::Path::new("a\rb\nc.obj"), 2);
    assert_eq!(odd.to_string(), "a?b?c.obj:2");
}

#[test]
fn limits_hold() {
    let files = Files::new(&[
        ("ball.rad", BALL),
        ("deep.rad", "!xform -a 1000 -t 1 0 0 -a 1000 -t 0 1 0 -a 1000 -t 0 0 1 ball.rad\n"),
        ("square.obj", SQUARE),
    ]);
    let load = |name: &str, limits: Limits| {
        let options = ImportOptions { limits, bare: true };
        load(&[files.path(name)], &options).expect_err(name).to_string()
    };
    let few = |change: &dyn Fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        limits
    };
    assert!(load("deep.rad", few(&|l| l.copies = 100)).contains("too many copies"));
    assert!(
        load("deep.rad", few(&|l| l.surfaces = 100)).contains("too many triangles and spheres")
    );
    assert!(load("deep.rad", few(&|l| l.text_bytes = 1000)).contains("too much text"));
    assert!(load("deep.rad", few(&|l| l.depth = 1)).contains("nested"));
    assert!(load("square.obj", few(&|l| l.file_bytes = 10)).contains("too long"));
    assert!(load("square.obj", few(&|l| l.corners = 3)).contains("too many corners"));
    assert!(load("square.obj", few(&|l| l.surfaces = 1)).contains("too many triangles"));
}
