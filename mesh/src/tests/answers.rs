//! What the ledger answers, message by message.

use crate::Ledger;
use kiloray_core::network::NodeId;
use kiloray_core::node::Time;
use kiloray_core::protocol::Message;
use kiloray_core::render::Tiling;
use kiloray_core::shade::Unit;
use kiloray_render::PictureError;

const A: NodeId = NodeId(0);
const B: NodeId = NodeId(7);
const MS: u64 = 1_000_000;

/// 16 tiles of 4 × 4 pixels, two askers.
fn ledger() -> Ledger {
    Ledger::new(16, 16, 4, 5, Unit::new(1.0), 1).unwrap().with_askers(2)
}

fn ask(ledger: &mut Ledger, at: u64, from: NodeId, number: u32, count: u32) -> (u32, u32, u32) {
    let mut given = None;
    ledger.on_message(Time(at), from, &Message::Ask { number, count }, &mut |to, reply| {
        let &Message::Grant { number: n, first, count, wait } = reply else { panic!("{reply:?}") };
        assert_eq!((to, n), (from, number));
        assert!(given.replace((first, count, wait)).is_none());
    });
    given.unwrap()
}

/// Sends sums of `pixels` pixels from `first`, each of this value: whether the tile was accepted.
fn send(
    ledger: &mut Ledger,
    at: u64,
    (tile, first): (u32, u32),
    pixels: usize,
    value: i64,
) -> bool {
    let sums: Vec<u8> = [value; 3].map(i64::to_le_bytes).as_flattened().repeat(pixels);
    let mut accepted = false;
    let message = Message::Pixels { tile, first, width: 8, sums: &sums };
    ledger.on_message(Time(at), A, &message, &mut |to, reply| {
        assert_eq!((to, *reply), (A, Message::Accepted { tile }));
        accepted = true;
    });
    accepted
}

#[test]
fn grants_shrink_as_work_does() {
    let mut ledger = ledger();
    // 16 places for two askers: a quarter.
    assert_eq!(ask(&mut ledger, 0, A, 0, 100), (0, 4, 0));
    assert_eq!(ask(&mut ledger, 0, B, 0, 100), (4, 3, 0));
    assert_eq!(ask(&mut ledger, 0, B, 1, 2), (7, 1, 0));
    assert_eq!(ask(&mut ledger, 0, B, 2, 2), (8, 2, 0));
    assert_eq!(ask(&mut ledger, 0, A, 1, 0), (12, 1, 0));
    // A third asker counts as well.
    let all: Vec<_> = (0..6).map(|n| ask(&mut ledger, 0, NodeId(3), n, 9)).collect();
    assert_eq!(all[..5], [14, 15, 11, 10, 13].map(|first| (first, 1, 0)));
    assert_eq!((all[5].1, ledger.counts().given), (0, 16));
}

#[test]
fn who_begins_a_run_goes_on_with_it_until_others_have_nothing_to_do() {
    let mut ledger = ledger();
    let mut first = |node, number| ask(&mut ledger, 0, node, number, 1).0;
    assert_eq!([first(A, 0), first(B, 0), first(A, 1), first(B, 1)], [0, 4, 1, 5]);
    let third = NodeId(3);
    assert_eq!([0, 1, 2, 3].map(|number| first(third, number)), [8, 9, 10, 11]);
    assert_eq!([4, 5, 6, 7].map(|number| first(third, number)), [12, 13, 14, 15]);
    // Half of what B has before it, as of two equally long rests the later; then half of that of A; and so on.
    assert_eq!([8, 9, 10].map(|number| first(third, number)), [7, 3, 6]);
    assert_eq!(first(A, 2), 2);
    assert_eq!((ask(&mut ledger, 0, B, 2, 1).1, ledger.counts().given), (0, 16));
}

#[test]
fn an_ask_that_comes_again_has_the_same_answer() {
    let mut ledger = ledger();
    assert_eq!(ask(&mut ledger, 0, A, 0, 4), (0, 4, 0));
    assert_eq!(ask(&mut ledger, 1, A, 0, 4), (0, 4, 0));
    // Somebody completes its first and third.
    for tile in [0, 2] {
        assert!(send(&mut ledger, MS, (tile, 0), 16, 9));
    }
    assert_eq!(ask(&mut ledger, 2 * MS, A, 0, 4), (1, 3, 0));
    assert_eq!(ledger.counts().repeated, 2);
    for tile in [1, 3] {
        assert!(send(&mut ledger, 2 * MS, (tile, 0), 16, 9));
    }
    // Nothing is left of it. What it would be given now would be nobody's, if the first answer came before it.
    assert_eq!(ask(&mut ledger, 3 * MS, A, 0, 4), (u32::MAX, 0, 1));
    assert_eq!(ask(&mut ledger, 3 * MS, A, 1, 4), (4, 3, 0));
    assert_eq!((ledger.counts().repeated, ledger.counts().given_again), (3, 0));
}

#[test]
fn an_ask_that_was_overtaken_is_given_nothing() {
    let mut ledger = ledger();
    assert_eq!(ask(&mut ledger, 0, A, 0, 1), (0, 1, 0));
    assert_eq!(ask(&mut ledger, 0, A, 1, 1), (1, 1, 0));
    assert_eq!(ask(&mut ledger, 0, A, 0, 1), (u32::MAX, 0, 1));
    assert_eq!(ask(&mut ledger, 0, A, 1, 1), (1, 1, 0), "what is open is still its own");
    // A node in place of this one begins at 0, and asks until it is where the other was.
    let place = (0..3).map(|number| ask(&mut ledger, 0, A, number, 1));
    assert_eq!(place.collect::<Vec<_>>(), [(u32::MAX, 0, 1), (1, 1, 0), (2, 1, 0)]);
    assert_eq!((ledger.counts().given, ledger.counts().given_again), (3, 0));
}

#[test]
fn that_there_is_none_is_an_answer_too() {
    let mut ledger = ledger();
    for number in 0..16 {
        let _ = ask(&mut ledger, 0, A, number, 1);
    }
    assert_eq!(ask(&mut ledger, 0, B, 7, 1).1, 0);
    // All are overdue by now. If this one were given a tile, and the first answer came before it, nobody would have that.
    assert_eq!(ask(&mut ledger, 3600 * 1000 * MS, B, 7, 1).1, 0);
    assert_eq!(ask(&mut ledger, 3600 * 1000 * MS, B, 8, 1).1, 1);
    assert_eq!((ledger.counts().repeated, ledger.counts().given_again), (1, 1));
}

#[test]
fn pixels_count_once_and_a_complete_tile_is_accepted_as_often_as_it_comes() {
    let mut ledger = ledger();
    let (tile, ..) = ask(&mut ledger, 0, A, 0, 1);
    assert!(!send(&mut ledger, 1, (tile, 0), 10, 5));
    assert!(!send(&mut ledger, 1, (tile, 4), 10, 5));
    assert_eq!((ledger.pixels_done(), ledger.counts().duplicates), (14, 6));
    assert!(send(&mut ledger, 1, (tile, 14), 2, 5));
    assert!(send(&mut ledger, 2, (tile, 14), 2, 5));
    assert_eq!((ledger.counts().duplicates, ledger.counts().differing), (8, 0));
    // Another sum would be another picture: the first stays, and it is counted.
    assert!(send(&mut ledger, 2, (tile, 0), 1, 6));
    assert_eq!(ledger.counts().differing, 1);
    assert!(!ledger.is_complete());
    let at = Tiling::new(16, 16, 4).shuffled(tile, 5).unwrap();
    let picture = ledger.picture();
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (i as u32 % 16, i as u32 / 16);
        let inside = (at.x..at.x + 4).contains(&x) && (at.y..at.y + 4).contains(&y);
        // Steps of 2⁻⁴³: the brightest radiance, 1, has the exponent 1.
        let expected = if inside { 5.0 / (1_u64 << 43) as f32 } else { 0.0 };
        assert_eq!(*pixel, [expected; 3], "{x} {y}");
    }
}

#[test]
fn what_does_not_exist_is_counted_and_left_alone() {
    let mut ledger = ledger();
    let bad: [(u32, u32, usize); 5] =
        [(16, 0, 1), (u32::MAX, 0, 1), (0, 16, 1), (0, u32::MAX, 2), (0, 0, 17 * 24)];
    for (tile, first, len) in bad {
        let sums = vec![0; 24 * len];
        let message = Message::Pixels { tile, first, width: 8, sums: &sums };
        ledger.on_message(Time(0), A, &message, &mut |_, _| panic!("no answer"));
    }
    for (width, len) in [(8, 25), (7, 24), (0, 24), (9, 27)] {
        let message = Message::Pixels { tile: 0, first: 0, width, sums: &[0; 27][..len] };
        ledger.on_message(Time(0), A, &message, &mut |_, _| panic!("no answer"));
    }
    for message in
        [Message::Accepted { tile: 0 }, Message::Fetch { block: 3, offset: 0, request: 0 }]
    {
        ledger.on_message(Time(0), A, &message, &mut |_, _| panic!("no answer"));
    }
    let counts = ledger.counts();
    assert_eq!(
        (counts.bad, counts.unexpected, counts.messages, ledger.pixels_done()),
        (9, 2, 0, 0)
    );
    for (width, height) in [(0, 4), (4, 0), (u32::MAX, 2), (1 << 30, 2)] {
        let size = Ledger::new(width, height, 8, 0, Unit::new(1.0), 1);
        assert!(matches!(size, Err(PictureError::Size { .. })), "{width} {height}");
    }
}

#[test]
fn the_first_lost_block_is_named() {
    let mut ledger = ledger();
    assert_eq!(ledger.lost(), None);
    for block in [12, 13] {
        ledger.on_message(Time(0), A, &Message::Lost { block }, &mut |_, _| panic!("no answer"));
    }
    assert_eq!(ledger.lost(), Some(12));
}

/// All 16 tiles are out, to A but for the last; A has completed 12 of them, each 1 ms after its grant.
fn nearly_done() -> Ledger {
    let mut ledger = ledger();
    for tile in 0..15 {
        let at = u64::from(tile) * MS;
        assert_eq!(ask(&mut ledger, at, A, tile, 1), (tile, 1, 0));
        if tile < 12 {
            assert!(send(&mut ledger, at + MS, (tile, 0), 16, 1));
        }
    }
    assert_eq!(ask(&mut ledger, 15 * MS, B, 0, 1), (15, 1, 0));
    ledger
}

#[test]
fn overdue_tiles_go_to_others_oldest_first_and_after_twice_as_long_each_time() {
    let mut ledger = nearly_done();
    // The deviation began at half a millisecond, and 11 samples without any have brought it down to about .25.
    let limit = 2 * MS + (4 + 16 / 12) * MS / 4;
    let (_, count, wait) = ask(&mut ledger, 15 * MS, B, 1, 1);
    assert_eq!(count, 0);
    // Tile 12 was given at 12 ms; the wait ends when it is overdue, or sooner, to ask whether tiles have been quicker.
    let due = 12 * MS + limit;
    assert!(u64::from(wait) * 1000 <= due - 15 * MS + 1000 && wait >= 100, "{wait}");
    let (mut at, mut number) = (15 * MS + u64::from(wait) * 1000, 2);
    let mut given = Vec::new();
    while given.len() < 3 {
        let (first, count, wait) = ask(&mut ledger, at, B, number, 1);
        number += 1;
        if count > 0 {
            given.push((first, at));
        }
        at += u64::from(wait) * 1000;
    }
    // One after the other, each a millisecond later, as they were given.
    for (k, &(tile, at)) in given.iter().enumerate() {
        let due = due + k as u64 * MS;
        assert_eq!(tile, 12 + k as u32);
        assert!(
            (due.saturating_sub(50_000)..due + 50_000).contains(&at),
            "{tile}: {at}, not {due}"
        );
    }
    assert_eq!(ledger.counts().given_again, 3);
    // The tile of B, which is overdue to others, and the first two are due before the third is for the second time.
    let again = given[2].1 + 2 * limit;
    for (node, at) in [(20, again - 200_000), (30, again + 200_000)] {
        let askers = (node..node + 4).map(NodeId);
        let tiles: Vec<_> = askers.map(|n| ask(&mut ledger, at, n, 0, 1)).collect();
        let tiles: Vec<_> = tiles.iter().filter(|t| t.1 > 0).map(|t| t.0).collect();
        let expected = if at < again { vec![15, 12, 13] } else { vec![14] };
        assert_eq!(tiles, expected);
    }
}

#[test]
fn the_only_asker_gets_what_it_lost_itself() {
    let mut ledger = Ledger::new(8, 8, 8, 0, Unit::new(1.0), 1).unwrap();
    assert_eq!(ask(&mut ledger, 0, A, 0, 1), (0, 1, 0));
    let (mut at, mut asks) = (0, 0);
    loop {
        let (_, count, wait) = ask(&mut ledger, at, A, 1 + asks, 1);
        if count > 0 {
            break;
        }
        asks += 1;
        at += u64::from(wait) * 1000;
    }
    // Twice the first limit, as it holds the tile; each wait is as long as all before it.
    assert_eq!(at, 2_000_000_000);
    assert!(asks < 20, "{asks}");
}

#[test]
fn when_all_is_there_nobody_needs_to_ask_again() {
    let mut ledger = Ledger::new(8, 4, 4, 0, Unit::new(1.0), 1).unwrap();
    for tile in 0..2 {
        let _ = ask(&mut ledger, 0, A, tile, 1);
        assert!(send(&mut ledger, MS, (tile, 0), 16, 1));
    }
    assert!(ledger.is_complete());
    assert_eq!(ask(&mut ledger, 2 * MS, B, 0, 1), (u32::MAX, 0, u32::MAX));
    assert_eq!(ask(&mut ledger, 2 * MS, A, 1, 1), (u32::MAX, 0, u32::MAX));
}

/// By the order in which they were given: no oracle but the places that are out, each with one holder.
#[test]
fn who_finds_no_tile_is_told_who_has_some() {
    let mut ledger = ledger();
    // A asks for one tile in four, and has the first run; the others are B's.
    let (mut of_a, mut of_b) = (0.., 4..);
    for number in 0..16 {
        let (asker, tiles) = if number % 4 == 0 { (A, &mut of_a) } else { (B, &mut of_b) };
        assert_eq!(Some(ask(&mut ledger, 0, asker, number, 1).0), tiles.next());
    }
    let named: Vec<_> = (0..16).map(|n| ask(&mut ledger, 1, NodeId(3), n, 1).0).collect();
    let times = |node: NodeId| named.iter().filter(|&&n| n == u32::from(node.0)).count();
    assert_eq!((times(A), times(B)), (4, 12), "{named:?}");
    // Nobody is sent to itself.
    assert_eq!(ask(&mut ledger, 2, A, 13, 1).0, u32::from(B.0));
    assert_eq!(ask(&mut ledger, 2, B, 16, 1).0, u32::from(A.0));
    for tile in 4..16 {
        assert!(send(&mut ledger, 3, (tile, 0), 16, 9));
    }
    assert_eq!(ask(&mut ledger, 4, NodeId(3), 16, 1).0, u32::from(A.0));
}
