/// Adds counts to counts of the same kind: sums, of peaks the greater, and parts that are counts themselves. All fields are named, or it does not compile.
macro_rules! tally {
    ($to:ident, $from:expr, $of:ident {
        $(sum $($sum:ident),+;)? $(max $($peak:ident),+;)? $(parts $($part:ident),+;)?
    }) => {
        let $of { $($($sum,)+)? $($($peak,)+)? $($($part,)+)? } = $from;
        $($($to.$sum = $to.$sum.saturating_add((*$sum).into());)+)?
        $($($to.$peak = $to.$peak.max(*$peak);)+)?
        $($($to.$part.add($part);)+)?
    };
}
pub(crate) use tally;
