//! A few cases of `same_bits`; its command runs all of them.

use kiloray_tests::pool;
use kiloray_tests::same_bits::Matrix;
use std::ops::ControlFlow;

#[test]
fn every_mesh_gives_the_bits_of_one_machine() {
    let matrix = Matrix::new(&["cornell".into(), "glass".into()], 1).unwrap();
    let small: Vec<_> = matrix.cases().iter().filter(|case| case.nodes() <= 16).collect();
    pool::each(0..12, 2, &|number| {
        if let Err(failure) = matrix.run(small[number as usize]) {
            panic!("{failure}");
        }
        ControlFlow::Continue(())
    });
}
