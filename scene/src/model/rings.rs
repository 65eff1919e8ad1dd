//! Outline and holes of a polygon whose holes are joined to it by seams.

use std::collections::HashMap;

/// A point by its bits, 0 and -0 alike.
type Key = [u64; 2];

/// Takes seams apart, edges that run there and, later, back: the rings of corners that are left, by their indices. A polygon without seams is one ring.
pub(super) fn rings(points: &[[f64; 2]]) -> Vec<Vec<u32>> {
    let key = |corner: u32| -> Key {
        points.get(corner as usize).map_or([0; 2], |point| point.map(|x| (x + 0.0).to_bits()))
    };
    let mut rings = Vec::new();
    // The way from the first corner, and where each of its edges begins.
    let mut way: Vec<u32> = Vec::with_capacity(points.len());
    let mut begins: HashMap<(Key, Key), usize> = HashMap::new();
    let mut add = |ring: &[u32]| {
        if ring.len() >= 3 {
            rings.push(ring.to_vec());
        }
    };
    for corner in (0..points.len() as u32).chain(points.first().map(|_| 0)) {
        let to = key(corner);
        let Some(&last) = way.last() else {
            way.push(corner);
            continue;
        };
        let from = key(last);
        if from == to {
            continue;
        }
        if let Some(&at) = begins.get(&(to, from)) {
            // It was gone before: what lies between there and here is a ring, and ends where it began.
            add(way.get(at + 1..way.len() - 1).unwrap_or_default());
            for pair in way.get(at..).unwrap_or_default().windows(2) {
                begins.remove(&(key(pair[0]), key(pair[1])));
            }
            way.truncate(at + 1);
        } else {
            begins.insert((from, to), way.len() - 1);
            way.push(corner);
        }
    }
    // The last corner is the first.
    add(way.get(..way.len().saturating_sub(1)).unwrap_or_default());
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTLINE: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
    const HOLE: [[f64; 2]; 4] = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]];

    fn lengths(points: &[[f64; 2]]) -> Vec<usize> {
        let mut lengths: Vec<_> = rings(points).iter().map(Vec::len).collect();
        lengths.sort_unstable();
        lengths
    }

    #[test]
    fn a_seam_joins_two_rings() {
        assert_eq!(rings(&OUTLINE), [[0, 1, 2, 3]]);
        let joined = [&OUTLINE[..], &OUTLINE[..1], &HOLE[..], &HOLE[..1]].concat();
        assert_eq!(lengths(&joined), [4, 4]);
        // Wherever it begins, there or in the hole, or in the middle of the seam.
        for begin in 0..joined.len() {
            let turned = [&joined[begin..], &joined[..begin]].concat();
            assert_eq!(lengths(&turned), [4, 4], "{begin}");
        }
    }

    #[test]
    fn holes_hang_on_holes() {
        let other = HOLE.map(|[x, y]| [x + 1.5, y + 1.5]);
        // From the outline to a hole, from that to another, and all the way back.
        let chain = [
            &OUTLINE[..],
            &OUTLINE[..1],
            &HOLE[..3],
            &other[..],
            &other[..1],
            &HOLE[2..],
            &HOLE[..1],
        ]
        .concat();
        assert_eq!(lengths(&chain), [4, 4, 4]);
        // Both on one corner.
        let fan =
            [&OUTLINE[..], &OUTLINE[..1], &HOLE, &HOLE[..1], &OUTLINE[..1], &other, &other[..1]];
        assert_eq!(lengths(&fan.concat()), [4, 4, 4]);
        assert_eq!(lengths(&[[0.0, 0.0], [1.0, 0.0]]), [0; 0]);
        assert_eq!(lengths(&[]), [0; 0]);
    }
}
