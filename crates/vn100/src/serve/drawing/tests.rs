//! What is drawn, how often, and how much of it is kept.

mod watched;

use axum::body::BodyDataStream;
use tokio::{sync::Semaphore, time};
use tokio_stream::StreamExt;
use tokio_util::sync::CancellationToken;
use vn100_analysis::{
    Analysis, Settings,
    protocol::{VNIMU, stream::Batch},
};

use super::*;
use crate::serve::events::EventReader;

/// Two parts of the first page, and one of the second.
fn parts(htmls: [&str; 2]) -> Vec<(usize, Arc<PagePart>)> {
    let part = |page, id, html: &str| (page, Arc::new(PagePart { id, html: html.into() }));
    vec![part(0, "a", htmls[0]), part(0, "b", htmls[1]), part(1, "a", "other")]
}

#[test]
fn a_reader_gets_what_has_changed_since_it_read() {
    let first = PageState { run: 7, ..PageState::default() }.next(parts(["1", "x"]));
    let since = |page: &PageState, seen: &PageState| -> Vec<String> {
        page.since(seen.version, 0).map(|part| format!("{}{}", part.id, part.html)).collect()
    };
    assert_eq!(since(&first, &PageState::default()), ["a1", "bx"]);
    assert!(since(&first, &first).is_empty());
    let second = first.next(parts(["2", "x"]));
    assert_eq!(since(&second, &first), ["a2"]);
    let third = second.next(parts(["3", "y"]));
    // one who has skipped the second state
    assert_eq!(since(&third, &first), ["a3", "by"]);
    assert_eq!(third.next(parts(["3", "y"])).version, third.version, "nothing has changed");
}

#[test]
fn what_is_asked_for_often_is_made_once_in_a_while() {
    let begin = Instant::now();
    let mut drawer = drawer_of(Vec::new(), begin);
    let made: Vec<Bytes> =
        [0, 1, 249, 250, 251].map(|ms| begin + Duration::from_millis(ms)).map(|now| drawer.documents(now)).into();
    let same = made.windows(2).filter(|pair| pair[0].as_ptr() == pair[1].as_ptr()).count();
    assert_eq!(same, 3);
}

/// An hour of noise, a row a second.
fn hour(state: &mut u64) -> Batch {
    let mut counts = Vec::with_capacity(3600 * VNIMU.channels.len());
    for _ in 0..counts.capacity() {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        counts.push((*state >> 33) as i32 % 1001);
    }
    Batch { layout: Some(Arc::new(VNIMU.clone())), counts, ..Batch::default() }
}

fn drawer_of(sources: Vec<ServedSource>, begin: Instant) -> Drawer {
    let evaluation = Evaluation::new(None, Vec::new(), false).unwrap();
    Drawer::new(sources, Arc::new(evaluation), String::new(), 0.95, begin)
}

/// A day of data ten thousand times as fast: what is kept is that of the last hour.
#[test]
fn a_day_of_data_is_drawn_without_growing() {
    let settings = Settings { rate_hz: Some(1.0), recent: true, ..Settings::default() };
    let facts = SourceFacts { name: "day".into(), ..SourceFacts::default() };
    let (sender, state) = watch::channel(SourceState::new(facts, &settings));
    let begin = Instant::now();
    let mut drawer = drawer_of(vec![ServedSource { state, goals: Goals::default() }], begin);
    let (mut analysis, mut noise) = (Analysis::new(settings), 1);
    let mut kept = Vec::new();
    for hours in 1..=24 {
        analysis.absorb(&hour(&mut noise));
        sender.send_modify(|state| {
            state.stage = Stage::Measuring;
            state.snapshot = Arc::new(analysis.snapshot());
        });
        let now = begin + Duration::from_millis(360) * hours;
        drawer.look(now);
        let page = drawer.draw(now);
        let bytes: usize = page.parts.iter().map(|drawn| drawn.part.html.len()).sum();
        kept.push((page.parts.len(), bytes, drawer.documents(now).len(), drawer.metrics(now).len()));
    }
    assert_eq!(analysis.snapshot().timing.samples, 86_400);
    let (parts, bytes, document, metrics) = kept[23];
    for (hours, earlier) in [(6, kept[5]), (12, kept[11])] {
        // an octave adds a point to each curve and a row to each table
        let most = |size: usize| size + size / 5;
        assert_eq!(parts, earlier.0, "{hours} h");
        assert!(bytes <= most(earlier.1) && document <= most(earlier.2) && metrics <= most(earlier.3), "{kept:?}");
    }
}

/// All that a reader can have now.
async fn taken(events: &mut BodyDataStream) -> String {
    let mut text = String::new();
    while let Ok(Some(Ok(piece))) = time::timeout(Duration::from_millis(1), events.next()).await {
        text.push_str(std::str::from_utf8(&piece).unwrap());
    }
    text
}

// paused, the clock runs ahead to the next deadline as soon as nothing else is to be done
#[tokio::test(start_paused = true)]
async fn a_reader_who_sleeps_a_thousand_states_gets_the_last_one() {
    let first = PageState { run: 7, ..PageState::default() }.next(parts(["0", "x"]));
    let pages = watch::channel(Arc::new(first)).0;
    let permit = || Arc::new(Semaphore::new(1)).try_acquire_owned().ok();
    let over = CancellationToken::new();
    let sleeper = EventReader { states: pages.subscribe(), page: 0, place: None, over, stream: permit() };
    let mut sleeper = sleeper.answer().into_body().into_data_stream();
    for state in 1..=1000 {
        let next = pages.borrow().next(parts([&state.to_string(), "x"]));
        pages.send_replace(Arc::new(next));
    }
    let text = taken(&mut sleeper).await;
    assert!(!text.contains("other"), "of another page");
    assert!(text.contains("data: a\ndata: 1000\n") && text.contains("\nid: 7-1001\n\n"), "{text}");
    assert_eq!(text.matches("event: snapshot").count(), 2, "{text}");
    assert!(!taken(&mut sleeper).await.contains("snapshot"), "nothing is sent twice");
}
