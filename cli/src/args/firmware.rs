//! What a board's firmware takes of its RAM beside the memory of its node: rounded up from what `node-board/sizes` prints.

/// The future of the node's task, the buffers of its lines, and what else has its place from the start \[bytes\].
pub(crate) const STATICS: u64 = 15 << 10;
/// The deepest calls and an interrupt \[bytes\].
pub(crate) const STACK: u64 = 15 << 10;

/// The deepest stack that a node was seen to take: `node-board/painted`, a Cortex-M4F that renders `glass` with all features of materials \[bytes\].
pub(crate) const PAINTED: u64 = 8_944;
/// Where that was.
pub(crate) const PAINTED_ON: &str = "a Cortex-M4F";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_painted_stack_is_the_deepest_that_is_told() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../node-board/README.md");
        let text = std::fs::read_to_string(path).expect("it is there");
        let line = text.lines().find(|line| line.contains("paints the stack")).expect("a line");
        let told = line.split_once(" in `glass`").and_then(|(before, _)| before.rsplit_once(' '));
        let told = told.map(|(_, number)| number.replace(',', "")).expect(line);
        assert_eq!(told.parse(), Ok(PAINTED));
    }

    #[test]
    fn every_firmware_of_the_table_takes_no_more() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../node-board/README.md");
        let text = std::fs::read_to_string(path).expect("it is there");
        let rows = text
            .lines()
            .skip_while(|line| !line.starts_with("| features | flash, bytes | statics"))
            .skip(2)
            .take_while(|line| line.starts_with('|'));
        let mut count = 0;
        for row in rows {
            let number = |column: usize| -> u64 {
                row.split('|').nth(column).and_then(|cell| cell.trim().parse().ok()).expect(row)
            };
            assert!(number(3) <= STATICS && number(4) <= STACK, "{row}");
            count += 1;
        }
        assert_eq!(count, 9);
    }
}
