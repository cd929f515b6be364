//! The same as bytes: states merge to what the undivided record says, and say what they cannot.

use vn100_analysis::{State, StateError};

use super::*;

/// Merged in an order that these choose, each through its bytes.
fn merged(states: Vec<State>, order: &[Index]) -> Result<State, StateError> {
    let mut states: Vec<Vec<u8>> = states.iter().map(State::to_bytes).collect();
    for place in order.iter().cycle() {
        if states.len() < 2 {
            break;
        }
        let one = State::from_bytes(&states.swap_remove(place.index(states.len())))?;
        let other = State::from_bytes(&states.swap_remove(place.index(states.len())))?;
        states.push(one.merged(other)?.to_bytes());
    }
    states.first().map_or_else(|| Ok(State::default()), |bytes| State::from_bytes(bytes))
}

fn of(record: &Record, name: &str, starts: &[Index], rows: usize) -> Vec<State> {
    record.cut(starts, rows).into_iter().map(|mut piece| State::of(name, None, &mut piece)).collect()
}

fn assert_said(state: &State, name: &str, whole: &str) -> Result<(), TestCaseError> {
    let found = state.recordings().find(|recording| recording.name == name).unwrap();
    let analysis = found.analysis().unwrap().unwrap();
    let pieces = said(&analysis);
    for (whole, pieces) in whole.lines().zip(pieces.lines()) {
        prop_assert_eq!(whole, pieces);
    }
    prop_assert_eq!(whole.len(), pieces.len());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn states_merged_in_any_order_say_what_the_whole_says(
        record in records(),
        starts in vec(any::<Index>(), 1..6),
        orders in (vec(any::<Index>(), 6), vec(any::<Index>(), 6)),
        rows in 1_usize..500,
    ) {
        let whole = record.analysed(record.whole(), 100);
        if record.cut(&starts, rows).is_empty() || record.pieced(&starts, &orders.0, rows).is_err() {
            return Ok(());
        }
        let one = match merged(of(&record, "a", &starts, rows), &orders.0) {
            // two pieces without a row at one place
            Err(StateError::Overlap { start, end, .. }) if start == end => {
                prop_assert!(merged(of(&record, "a", &starts, rows), &orders.1).is_err());
                return Ok(());
            }
            one => one.unwrap(),
        };
        assert_said(&one, "a", &said(&whole))?;
        let other = merged(of(&record, "a", &starts, rows), &orders.1).unwrap();
        prop_assert_eq!(one.to_bytes(), other.to_bytes(), "whatever the order");
        let other = other.joined();
        assert_said(&other, "a", &said(&whole))?;
        prop_assert_eq!(State::from_bytes(&one.to_bytes()).unwrap().to_bytes(), one.to_bytes());
    }

    #[test]
    fn recordings_stay_side_by_side(
        records in (records(), records()),
        starts in vec(any::<Index>(), 1..4),
        order in vec(any::<Index>(), 6),
    ) {
        let (one, other) = (&records.0, &records.1);
        if [one, other].iter().any(|record| record.pieced(&starts, &order, 99).is_err() || record.lines.is_empty()) {
            return Ok(());
        }
        let mut states = of(one, "one", &starts, 99);
        states.extend(of(other, "other", &starts, 77));
        states.push(State::unreadable("broken", "no such file"));
        let state = match merged(states, &order) {
            Err(StateError::Overlap { start, end, .. }) if start == end => return Ok(()),
            state => state.unwrap(),
        };
        prop_assert_eq!(state.recordings().map(|recording| recording.name).collect::<Vec<_>>(), ["broken", "one", "other"]);
        assert_said(&state, "one", &said(&one.analysed(one.whole(), 100)))?;
        assert_said(&state, "other", &said(&other.analysed(other.whole(), 100)))?;
    }

    #[test]
    fn damaged_bytes_are_no_state(record in records(), place in any::<Index>(), bit in 0_u8..8, cut in any::<Index>()) {
        let bytes = State::of("a", Some(5), &mut record.analysed(record.whole(), 100)).to_bytes();
        let mut damaged = bytes.clone();
        damaged[place.index(bytes.len())] ^= 1_u8 << bit;
        prop_assert!(State::from_bytes(&damaged).is_err());
        let short = &bytes[..cut.index(bytes.len())];
        let is_told = matches!(State::from_bytes(short), Err(StateError::Truncated { .. } | StateError::NotAState));
        prop_assert!(is_told, "{} of {} bytes", short.len(), bytes.len());
    }
}

#[test]
fn a_row_that_comes_again_and_again_is_in_the_state() {
    for value in [0, 1, -7] {
        let layout = Layout { channels: VNYMR.channels[9..10].into(), ..VNYMR.clone() };
        let mut analysis = Analysis::new(Settings { rate_hz: Some(40.0), ..Settings::default() });
        let counts = vec![value; 20_000];
        analysis.absorb(&Batch { layout: Some(Arc::new(layout)), counts, ..Batch::default() });
        let state = State::of("a", None, &mut analysis);
        let found = state.recordings().next().unwrap();
        assert_eq!(found.error, None);
        assert_eq!(found.analysis().unwrap().unwrap().timing().samples, 20_000);
    }
}

#[test]
fn what_cannot_be_merged_is_said() {
    let record = |rows| Record {
        layout: VNIMU.clone(),
        lines: vec![Line::Good([1; 13]); rows],
        has_counters: false,
        settings: Settings::default(),
    };
    let state = |rows| State::of("a", None, &mut record(rows).analysed(record(rows).whole(), 10));
    let overlap = state(5).merged(state(4)).unwrap_err();
    assert_eq!(overlap, StateError::Overlap { recording: "a".into(), start: 0, end: 5 });
    let facts = state(5).merged(State::unreadable("a", "gone")).unwrap_err();
    assert_eq!(facts, StateError::OtherFacts { recording: "a".into() });
    let ymr = Record { layout: VNYMR.clone(), ..record(5) };
    let ymr = State::of("a", None, &mut ymr.analysed(ymr.whole(), 10));
    assert_eq!(state(5).merged(ymr).unwrap_err(), StateError::OtherMessage { recording: "a".into() });
    let mut coarse = VNIMU.clone();
    coarse.channels.to_mut()[1].scale = 0.5;
    let coarse = Record { layout: coarse, ..record(5) };
    let coarse = State::of("a", None, &mut coarse.analysed(coarse.whole(), 10));
    let (channel, scale) = (VNIMU.channels[1].name.to_string(), VNIMU.channels[1].scale);
    let other_scale = StateError::OtherScale { recording: "a".into(), channel, scale, other: 0.5 };
    assert_eq!(state(5).merged(coarse).unwrap_err(), other_scale);
    let bytes = state(5).to_bytes();
    let with = |place: usize, byte: u8| {
        let mut bytes = bytes.clone();
        bytes[place] = byte;
        State::from_bytes(&bytes).unwrap_err()
    };
    assert_eq!(with(0, b'X'), StateError::NotAState);
    assert_eq!(with(4, 9), StateError::OtherVersion { found: 9, known: 3 });
    assert!(matches!(with(6, !bytes[6]), StateError::OtherLayout { .. }));
    assert!(matches!(with(40, !bytes[40]), StateError::Damaged { .. }));
    assert!(matches!(State::from_bytes(&bytes[..bytes.len() - 1]), Err(StateError::Truncated { .. })));
}
