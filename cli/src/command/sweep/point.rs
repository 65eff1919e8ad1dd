use std::ffi::OsString;

use crate::{
    args::{self, Sim},
    failure::{Failure, Outcome},
};

/// Most points of a sweep.
const POINTS_MAX: usize = 20_000;

/// A combination of the axes' values.
#[derive(Debug)]
pub(super) struct Point {
    /// A value of each axis, in their order; or an axis and its value, where one is varied at a time.
    pub(super) values: Vec<String>,
    /// The command it stands for.
    pub(super) sim: Sim,
    /// Which of the compiled scenes.
    pub(super) scene: usize,
}

/// What the values of points are called.
pub(super) fn heads(sweep: &args::Sweep) -> Vec<&str> {
    if sweep.each {
        return vec!["over", "value"];
    }
    sweep.over.iter().map(|axis| axis.option.as_str()).collect()
}

/// All points, the last axis counting fastest. Every value is looked at before the first run.
pub(super) fn points(sweep: &args::Sweep) -> Outcome<Vec<Point>> {
    for (i, axis) in sweep.over.iter().enumerate() {
        if sweep.over[..i].iter().any(|other| other.option == axis.option) {
            return Err(Failure::usage(format_args!(
                "--over {0} is given twice; write all values in one, as in --over {0}=A,B",
                axis.option
            )));
        }
    }
    if sweep.each {
        let all = sweep.over.iter().flat_map(|axis| axis.values.iter().map(move |v| (axis, v)));
        let points = all.map(|(axis, value)| {
            let sim = args::point(&sweep.typed, &[(&axis.option, value)])?;
            Ok(Point { values: vec![axis.option.clone(), value.clone()], sim, scene: 0 })
        });
        return points.collect();
    }
    let count = sweep.over.iter().try_fold(1_usize, |n, axis| n.checked_mul(axis.values.len()));
    let count = count.filter(|&n| n <= POINTS_MAX).ok_or_else(|| {
        Failure::usage(format_args!("the axes make more than the {POINTS_MAX} points that can be"))
    })?;
    (0..count).map(|index| point(sweep, index, &sweep.typed)).collect()
}

fn point(sweep: &args::Sweep, mut index: usize, typed: &[OsString]) -> Outcome<Point> {
    let mut values = Vec::with_capacity(sweep.over.len());
    for axis in sweep.over.iter().rev() {
        values.push(axis.values[index % axis.values.len()].clone());
        index /= axis.values.len();
    }
    values.reverse();
    let named: Vec<_> =
        sweep.over.iter().zip(&values).map(|(a, v)| (a.option.as_str(), v.as_str())).collect();
    let sim = args::point(typed, &named)?;
    Ok(Point { values, sim, scene: 0 })
}
