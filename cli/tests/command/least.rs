//! The least memory that a refusal names.

use crate::support::Folder;

/// What a refusal names.
fn named(folder: &Folder, line: &str) -> u64 {
    let told = folder.run(line).err();
    let (_, need) = told.split_once("at least ").unwrap_or_else(|| panic!("{line}: {told}"));
    let (need, _) = need.split_once(" bytes").expect("a unit");
    need.parse().expect("a number")
}

#[test]
fn what_a_refusal_names_is_accepted_and_one_byte_less_is_not() {
    let folder = Folder::new();
    folder.run("compile colour-cube --block 4KiB -o cube.kilo -q").done();
    for mesh in [
        // Less than the greatest memory of blocks of 1 KiB, and more, which has greater ones.
        "glass --nodes 16",
        "glass --nodes 500 --topology full",
        "sinc:150 --nodes 2 --owned-in-arena",
        "colour-cube --nodes 3 --owned-in-arena",
        "colour-cube --nodes 3 --owned-in-arena --block 2KiB",
        "cube.kilo --nodes 3 --owned-in-arena",
        "glass --nodes 16 --block 64KiB",
    ] {
        for memory in ["1KiB", "64KiB", "513KiB"] {
            let plan = |memory: &str| folder.run(&format!("plan {mesh} --memory {memory}"));
            if plan(memory).code() == Some(0) {
                continue;
            }
            let need = named(&folder, &format!("plan {mesh} --memory {memory}"));
            plan(&need.to_string()).done();
            plan(&(need - 1).to_string()).refused(1, &["too small", &need.to_string()]);
        }
    }
}

#[test]
fn all_commands_of_meshes_name_the_same() {
    let folder = Folder::new();
    let mesh = "sinc:100 --nodes 2 --topology line --memory 16KiB";
    let plan = named(&folder, &format!("plan {mesh} --block 16KiB"));
    let sim = format!("sim {mesh} --block 16KiB");
    assert_eq!(named(&folder, &sim), plan);
    let own = "--nodes 2 --topology line --owned-in-arena";
    let plan = named(&folder, &format!("plan sinc:200 {own} --memory 32KiB"));
    folder
        .run(&format!("sim sinc:200 {own} --memory 32KiB"))
        .refused(1, &[&format!("at least {plan} bytes"), ", which get blocks of "]);
    assert_eq!(folder.names(), [""; 0]);
}
