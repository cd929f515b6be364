//! Rows that lack channels: each channel is as in a record of its own, and the others as if the
//! column with the holes were not there.

use std::sync::Arc;

use proptest::{collection::vec, prelude::*};
use vn100_analysis::{Analysis, Finding, Settings, noise::Histogram};
use vn100_protocol::stream::{AbsentCell, Arrival, Batch, Mark, MarkKind};
use vn100_protocol::{Channel, Layout, VNIMU, VNYMR};

/// The attitude and the accelerations of a message, or its sensors with temperature and pressure.
fn layouts() -> [Layout; 2] {
    let angles = Layout { channels: VNYMR.channels[..9].to_vec().into(), ..VNYMR.clone() };
    [angles, VNIMU.clone()]
}

/// The counts of a row, by channel; `None` for none.
type Row = Vec<Option<i32>>;

/// The channels in `kept`; rows stamped at 40 Hz where asked for, in batches of these sizes.
fn analysed(layout: &Layout, kept: &[usize], rows: &[Row], cuts: &[usize], stamped: bool) -> Analysis {
    let channels: Vec<Channel> = kept.iter().map(|&place| layout.channels[place].clone()).collect();
    let layout = Arc::new(Layout { channels: channels.into(), ..layout.clone() });
    let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
    let (mut rest, mut number) = (rows, 0);
    for cut in cuts.iter().copied().cycle() {
        let (now, later) = rest.split_at(cut.min(rest.len()));
        let mut batch = Batch { layout: Some(Arc::clone(&layout)), ..Batch::default() };
        for row in now {
            let from_row = batch.row_count();
            if stamped {
                batch.arrivals.push(Arrival { from_row, at_ns: 25_000_000 * number });
            }
            number += 1;
            if kept.iter().all(|&place| row[place].is_none()) && kept.len() == 1 {
                batch.marks.push(Mark { before_row: from_row, kind: MarkKind::Rejected });
                batch.arrivals.pop();
                continue;
            }
            for (channel, &place) in kept.iter().enumerate() {
                batch.counts.push(row[place].unwrap_or(77));
                if row[place].is_none() {
                    batch.absent.push(AbsentCell { row: from_row, channel });
                }
            }
        }
        analysis.absorb(&batch);
        rest = later;
        if rest.is_empty() {
            break;
        }
    }
    analysis.finish();
    analysis
}

/// Every bit of the channels at these places.
fn said(analysis: &Analysis, places: &[usize]) -> Vec<String> {
    let snapshot = analysis.final_snapshot();
    let of = |&place: &usize| {
        let mut channel = snapshot.channels[place].clone();
        let signal = channel.signal.take().unwrap();
        let bins: Vec<_> = channel.histogram.bins().collect();
        channel.histogram = Histogram::new();
        format!(
            "{:?} {bins:?} {:?} {channel:?}",
            signal.blocks(),
            signal.spectrum().density(vn100_analysis::noise::Sides::One, 0.025, 3)
        )
    };
    places.iter().map(of).collect()
}

/// Rows of so many channels that lack some of those at even places, in bursts and one by one.
fn rows(width: usize) -> impl Strategy<Value = Vec<Row>> {
    let hole = prop_oneof![6 => Just(0..0), 1 => (0..width, 1..4_usize).prop_map(|(from, n)| from..from + n)];
    let stretch = (1_usize..400, vec(-2000..2000, width), hole, 1_usize..40);
    vec(stretch, 1..8).prop_map(move |stretches| {
        let mut rows = Vec::new();
        for (number, level, hole, every) in stretches {
            for row in 0..number {
                let lacks = |channel| channel % 2 == 0 && hole.contains(&channel) && row % every == 0;
                let count = |channel: usize| level[channel] + ((rows.len() * 7919 + channel * 104_729) % 61) as i32;
                rows.push((0..width).map(|channel| (!lacks(channel)).then(|| count(channel))).collect());
            }
        }
        rows
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn holes_are_those_of_their_own_channel(
        (layout, rows) in (0..2_usize).prop_flat_map(|which| {
            let layout = layouts()[which].clone();
            let width = layout.channels.len();
            (Just(layout), rows(width))
        }),
        cuts in vec(1_usize..300, 1..6),
        stamped in any::<bool>(),
    ) {
        let all: Vec<usize> = (0..layout.channels.len()).collect();
        let odd: Vec<usize> = all.iter().copied().filter(|place| place % 2 == 1).collect();
        let whole = analysed(&layout, &all, &rows, &[usize::MAX], stamped);
        let cut = analysed(&layout, &all, &rows, &cuts, stamped);
        prop_assert_eq!(said(&whole, &all), said(&cut, &all), "cut otherwise");
        prop_assert_eq!(format!("{:?}", whole.snapshot().magnitudes), format!("{:?}", cut.snapshot().magnitudes));
        let others = analysed(&layout, &odd, &rows, &cuts, stamped);
        let places: Vec<usize> = (0..odd.len()).collect();
        prop_assert_eq!(said(&whole, &odd), said(&others, &places), "without the columns that have holes");
        // one column alone, where a row without it is a lost row between two others
        for &place in all.iter().filter(|place| **place % 2 == 0) {
            let present = |row: &Row| row[place].is_some();
            if !present(&rows[0]) || !rows.last().is_some_and(present) || stamped {
                continue;
            }
            let alone = analysed(&layout, &[place], &rows, &cuts, stamped);
            prop_assert_eq!(said(&whole, &[place]), said(&alone, &[0]), "{} alone", layout.channels[place].name);
        }
    }
}

#[test]
fn channels_that_rows_lack_are_named_with_their_counts() {
    let layout = Arc::new(VNYMR.clone());
    let counts = vec![0; 8 * layout.channels.len()];
    // of eight rows, five lack the first channel and four the second
    let cells = [(0, 5), (1, 4)].map(|(channel, rows)| (0..rows).map(move |row| AbsentCell { row, channel }));
    let mut absent: Vec<AbsentCell> = cells.into_iter().flatten().collect();
    absent.sort_by_key(|cell| (cell.row, cell.channel));
    let mut analysis = Analysis::new(Settings::default());
    analysis.absorb(&Batch { layout: Some(layout), counts, absent, ..Batch::default() });
    analysis.finish();
    let warnings = analysis.snapshot().warnings;
    let found = Finding::Absent(8, vec![("yaw".into(), 5), ("pitch".into(), 4)]);
    assert!(
        warnings.iter().any(|warning| warning.finding == found && warning.channels == ["yaw", "pitch"]),
        "{warnings:?}"
    );
}
